"""Breakout of tread material due to rolling contact fatigue, Eq. (22)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..inputs.schema import quantity
from ..runtime.arrays import Real
from .surface import WHEELS, Patch, Surface, check_shape

TREAD_HALF_WIDTH = 0.050
"""Reach of a defect to either side of the rolling circle, m.

A tread 135 mm wide ends about 40 mm to the flange side and 60 mm to the field side of the rolling circle; the wheel
modelled is a cylinder without flange (Section 5), so both sides share the mean.
"""


@dataclass(frozen=True)
class Breakout:
    """One breakout: an ellipse whose depth follows a cosine from ``h`` at the centre to 0 at the rim (Eq. 22)."""

    type: ClassVar[str] = "breakout"

    on: Literal["wheel_1", "wheel_2"]
    a: float = quantity("m", 0.001, 0.2, "longitudinal semi-axis")
    b: float = quantity("m", 0.001, TREAD_HALF_WIDTH, "lateral semi-axis")
    h: float = quantity("m", 0.0, 0.010, "depth")
    angle: float = quantity(
        "rad", -2 * np.pi, 2 * np.pi, "angle of the centre, in the order in which the tread meets the rail", default=0.0
    )
    y: float = quantity(
        "m", -TREAD_HALF_WIDTH, TREAD_HALF_WIDTH, "lateral position of the centre from the rolling circle", default=0.0
    )

    def __post_init__(self) -> None:
        check_shape(self, WHEELS)
        check_reach(self.y, self.b)

    @property
    def half_length(self) -> float:
        """Half the extent along the tread, m."""
        return self.a

    def height(self, s: ArrayLike, y: ArrayLike) -> Real:
        """Height of the surface over the nominal one, m; negative where material is missing (Eq. 22).

        ``s`` is the longitudinal distance from the centre of the defect along the tread and ``y`` the lateral
        position on the tread, both in m; they broadcast.
        """
        return hollow(np.asarray(s, float) / self.a, (np.asarray(y, float) - self.y) / self.b, self.h)

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface`` at lateral positions ``y``, m."""
        yield surface.around(surface.at_angle(self.angle), self.a, lambda s: self.height(s, y))


def hollow(s: Real, y: Real, depth: float) -> Real:
    """Height of an ellipse that a cosine deepens, m; ``s`` and ``y`` are 1 at its rim (Eq. 22)."""
    radius = np.hypot(s, y)
    return np.where(radius <= 1.0, -0.5 * depth * (1.0 + np.cos(np.pi * np.minimum(radius, 1.0))), 0.0)


def check_reach(y: float, b: float) -> None:
    """Raise InputError for a defect at ``y`` of lateral semi-axis ``b``, m, that leaves the tread."""
    reach = abs(y) + b
    if reach > TREAD_HALF_WIDTH * (1 + 1e-12):
        raise InputError(
            f"b = {b:g} m at y = {y:g} m reaches {reach:g} m from the rolling circle, beyond the tread: "
            f"give |y| + b up to {TREAD_HALF_WIDTH:g} m"
        )
