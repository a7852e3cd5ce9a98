"""The burn that a slipping wheel leaves on a rail, as a kind of irregularity for ``wheelset_track_sim``.

A driven wheel that slips on one spot grinds its own circle into the rail head: a hollow of length L and depth
L^2 / (8 R), where R is the radius of the wheel, as wide as the contact and with steep sides.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.irregularities import Patch, Surface, check_shape, quantity


@dataclass(frozen=True)
class WheelBurn:
    """A hollow in the rail head with the radius of the wheel that burnt it."""

    type: ClassVar[str] = "wheel_burn"

    on: Literal["rail_1", "rail_2"]
    position: float = quantity("m", 0.0, 5000.0, "position of the middle along the track")
    length: float = quantity("m", 0.01, 0.2, "length of the burn")
    width: float = quantity("m", 0.005, 0.07, "width of the burn", default=0.03)
    radius: float = quantity("m", 0.3, 0.7, "radius of the wheel that slipped", default=0.46)

    def __post_init__(self) -> None:
        check_shape(self, ("rail_1", "rail_2"))

    @property
    def end(self) -> float:
        """Position where the burn ends, m."""
        return self.position + self.length / 2

    def height(self, s: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height (m) at ``s`` from the middle along the rail and ``y`` across it, m; negative in the hollow."""
        depth = (self.length**2 / 4 - s**2) / (2 * self.radius)
        inside = (np.abs(s) < self.length / 2) & (np.abs(y) < self.width / 2)
        return np.where(inside, -depth, 0.0)

    def patches(self, surface: Surface, y: NDArray[np.float64]) -> Iterable[Patch]:
        """Heights on the rail at lateral positions ``y``, m."""
        yield surface.around(surface.at(self.position), self.length / 2, lambda s: self.height(s, y))
