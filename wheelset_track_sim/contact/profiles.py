"""Nominal surfaces of wheel and rail, and the separation between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..schema import check, quantity
from .influence import contact_modulus


@dataclass(frozen=True)
class RailHead:
    """Crown of a rail: arcs that follow one another with a common tangent, symmetric about y = 0.

    The default is 60E1 of EN 13674-1: R300 to 20.456 mm of width, R80 to 52.053 mm, R13 to the head width of 72 mm.
    """

    radii: tuple[float, ...] = (0.300, 0.080, 0.013)
    """Radii from the middle outwards, m."""
    ends: tuple[float, ...] = (0.020456 / 2, 0.052053 / 2, 0.072 / 2)
    """Lateral positions where the arcs end, m."""

    def __post_init__(self) -> None:
        steps = np.diff((0.0, *self.ends))
        if len(self.radii) != len(self.ends) or not self.radii or not (steps > 0).all():
            raise InputError(f"ends = {self.ends} do not fit radii = {self.radii}: give one rising end for each radius")
        if not np.isfinite(self.drop(0.999 * self.half_width)):
            raise InputError(f"radii = {self.radii} m do not reach ends = {self.ends} m: give larger radii")

    @property
    def half_width(self) -> float:
        """Where the last arc ends, m."""
        return self.ends[-1]

    def drop(self, y: ArrayLike) -> NDArray[np.float64]:
        """Depth of the crown below its top at ``y``, m; infinite beside the head, where there is no running surface."""
        distance = np.abs(np.asarray(y, float))
        drop = np.full(distance.shape, np.inf)
        centre, depth, start, tangent = 0.0, self.radii[0], 0.0, 0.0
        for number, (radius, end) in enumerate(zip(self.radii, self.ends, strict=True)):
            if number:
                # Neighbouring arcs share the tangent, so their centres lie on one normal.
                before = self.radii[number - 1]
                centre += (before - radius) * np.sin(tangent)
                depth -= (before - radius) * np.cos(tangent)
            on = (distance >= start) & (distance <= end)
            with np.errstate(invalid="ignore"):
                drop[on] = depth - np.sqrt(radius**2 - (distance[on] - centre) ** 2)
                tangent = float(np.arcsin((end - centre) / radius))
            start = end
        return drop


@dataclass(frozen=True)
class ContactGeometry:
    """Wheel cylinder on a rail crown, both of one elastic material (Sections 2.3, 3 and 5)."""

    wheel_radius: float = quantity("m", 0.2, 1.0, "rolling radius of the wheel", default=0.43175)
    youngs_modulus: float = quantity("Pa", 1e9, 1e12, "Young's modulus of wheel and rail", default=210e9)
    poissons_ratio: float = quantity("", 0.0, 0.49, "Poisson's ratio of wheel and rail", default=0.3)
    head: RailHead = field(default_factory=RailHead)

    def __post_init__(self) -> None:
        check(self, "contact")

    @property
    def contact_modulus(self) -> float:
        """E*, Pa."""
        return contact_modulus(self.youngs_modulus, self.poissons_ratio)

    def separation(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """z_W + z_R of Eq. (9): distance between the undeformed surfaces that touch at the origin, m."""
        x = np.asarray(x, float)
        return x**2 / (self.wheel_radius + np.sqrt(self.wheel_radius**2 - x**2)) + self.head.drop(y)
