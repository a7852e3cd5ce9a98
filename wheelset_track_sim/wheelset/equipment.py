"""Equipment on the axle: rings, such as brake discs and gear wheels, and point masses.

``y`` is the axial coordinate, 0 at the track's centre, positive to the left in the running direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from ..errors import InputError
from ..inputs.schema import quantity
from .parts import Checked


@dataclass(frozen=True)
class OnAxle(Checked):
    """What stands on a cylinder of the axle from ``y - length / 2`` to ``y + length / 2``."""

    name: str
    y: float = quantity("m", -2.0, 2.0, "the y of its middle")
    length: float = quantity("m", 0.01, 1.0, "the length of axle on which it stands")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.name:
            raise InputError("equipment has an empty name: give each piece a name of its own")

    @property
    def ends(self) -> tuple[float, float]:
        """First and last y, m."""
        return self.y - self.length / 2, self.y + self.length / 2


@dataclass(frozen=True)
class Ring(OnAxle):
    """Hollow cylinder of the wheelset's material, tied to the axle: it adds mass and stiffness, as the gearbox does."""

    type: ClassVar[str] = "ring"
    outer_radius: float = quantity("m", 0.05, 0.7, "the outer radius of the ring")


@dataclass(frozen=True)
class PointMass(OnAxle):
    """Rigid mass without stiffness; it follows the mean lift and tilt of the axle's surface under it."""

    type: ClassVar[str] = "mass"
    mass: float = quantity("kg", 0.0, 2000.0, "the mass")
    inertia: float = quantity("kg m^2", 0.0, 500.0, "the moment of inertia about a diameter of the axle", default=0.0)


Equipment = Ring | PointMass


def clear_of_each_other(parts: list[tuple[str, float, float]]) -> None:
    """Raise InputError unless parts (what, first y, last y) stand beside each other; touching is fine."""
    ordered = sorted(parts, key=lambda part: part[1])
    for (before, _, end), (after, start, _) in pairwise(ordered):
        if start < end - 1e-9:
            raise InputError(
                f"{after} begins at y = {start:g} m, where {before} stands, which ends at {end:g} m: move one of them"
            )
