"""Wheels over rails: where they touch, and the separation between them around that point."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from .influence import contact_modulus
from .profiles import LateralProfile, RailHead, Straight

OUTWARDS = (-1.0, 1.0)
"""Which way the field side is under wheel 1, on the right, and wheel 2, on the left: y is positive to the left."""

STEEPEST = 0.2
"""Largest angle between contact and track plane, rad. The contact is solved as if it were 0: of a force that is normal
to the surfaces, 2 % less is vertical at this angle, and 20 % is lateral, which is left out."""
NEAR = 1e-4
"""Surfaces that are nearer than this where wheel and rail touch bear, too, under usual loads, m."""
FINE = 1e-5
"""Distance of the points at which profiles are looked at, m."""


@dataclass(frozen=True)
class ProfilePair:
    """Profile of a wheel over that of a rail. ``y`` counts outwards from the middle of the rail's head."""

    wheel: LateralProfile = field(default_factory=Straight)
    rail: LateralProfile = field(default_factory=RailHead)
    shift: float = 0.0
    """Where the rolling circle is, m."""

    def __post_init__(self) -> None:
        if self.fine[0].size == 0:
            raise InputError(f"shift = {self.shift:g} m moves the wheel off its rail: give a smaller one")

    @property
    def span(self) -> tuple[float, float]:
        """First and last y at which there are both surfaces, m."""
        (low, high), (inner, outer) = self.wheel.span, self.rail.span
        return max(low + self.shift, inner), min(high + self.shift, outer)

    @cached_property
    def fine(self) -> tuple[Real, Real, Real]:
        """Positions, m, heights of wheel and rail there, m."""
        low, high = self.span
        y = np.arange(np.ceil(low / FINE * (1 + 1e-12)), np.floor(high / FINE * (1 + 1e-12)) + 1) * FINE
        return y, self.wheel.height(y - self.shift), self.rail.height(y)

    @cached_property
    def least(self) -> float:
        """Least of what is between the profiles before they touch, m."""
        _, wheel, rail = self.fine
        return float((-wheel - rail).min())

    def gap(self, y: ArrayLike) -> Real:
        """Distance of the profiles that touch, m; infinite where one of them ends."""
        y = np.asarray(y, float)
        return -self.wheel.height(y - self.shift) - self.rail.height(y) - self.least

    def wheel_height(self, y: ArrayLike) -> Real:
        """What the radius of the wheel at ``y`` is larger than on the rolling circle, m."""
        return self.wheel.height(np.asarray(y, float) - self.shift)

    @cached_property
    def touch(self) -> float:
        """Where the profiles touch, m: the middle of where they are nearest."""
        y, wheel, rail = self.fine
        gap = -wheel - rail - self.least
        first = last = int(gap.argmin())
        while first > 0 and gap[first - 1] < 1e-9:
            first -= 1
        while last < len(y) - 1 and gap[last + 1] < 1e-9:
            last += 1
        return float(0.5 * (y[first] + y[last]))

    @cached_property
    def angle(self) -> tuple[float, float]:
        """Largest angle to the track plane where the profiles are ``NEAR`` each other, rad, and where, m."""
        y, wheel, rail = self.fine
        near = np.flatnonzero(-wheel - rail - self.least < NEAR)
        before, behind = np.maximum(near - 1, 0), np.minimum(near + 1, len(y) - 1)
        rise = 0.5 * (rail[behind] - wheel[behind] - rail[before] + wheel[before])
        slope = np.abs(rise) / (y[behind] - y[before])
        steepest = int(slope.argmax())
        return float(np.arctan(slope[steepest])), float(y[near[steepest]])

    @cached_property
    def open_gap(self) -> float:
        """Least gap at an end of points beyond which a body goes on, m; infinite without such an end."""
        gaps = [np.inf]
        for side in (0, 1):
            end = self.span[side]
            for profile, at in ((self.wheel, end - self.shift), (self.rail, end)):
                if profile.open_ends[side] and abs(profile.span[side] - at) < 1e-12:
                    gaps.append(float(self.gap(self.fine[0][-2 if side else 1])))
        return min(gaps)

    @property
    def crown(self) -> float:
        """Relative radius of curvature across the track where wheel and rail touch, over the width of a contact, m."""
        if isinstance(self.wheel, Straight) and isinstance(self.rail, RailHead) and abs(self.touch) < 1e-6:
            return self.rail.radii[0]
        return float(np.clip(np.mean(self._secant(0.006)), 0.02, 5.0))

    @property
    def sharpest(self) -> float:
        """A relative radius, m, that needs a larger approach for a force than these profiles do."""
        if isinstance(self.wheel, Straight) and isinstance(self.rail, RailHead):
            return min(self.rail.radii[:2])
        return float(np.clip(0.75 * min(min(self._secant(at)) for at in np.arange(2, 9) * 1e-3), 0.01, 5.0))

    def _secant(self, distance: float) -> list[float]:
        """Radius of the parabolas through the point of contact and the gaps at a distance to its sides, m."""
        gaps = [float(self.gap(self.touch + side * distance)) for side in (-1.0, 1.0)]
        return [distance**2 / (2.0 * max(gap, 1e-9)) for gap in gaps if np.isfinite(gap)] or [5.0]


@dataclass(frozen=True)
class ContactGeometry:
    """Both wheels on their rails, all of one elastic material (Sections 2.3, 3 and 5). ``y`` is positive to the left.

    The default are cylinders on rails 60E1, the paper's. Raises InputError where wheel and rail touch at an angle above
    ``STEEPEST``, as a flange does.
    """

    wheel_radius: float = quantity("m", 0.2, 1.0, "rolling radius of the wheel", default=0.43175)
    youngs_modulus: float = quantity("Pa", 1e9, 1e12, "Young's modulus of wheel and rail", default=210e9)
    poissons_ratio: float = quantity("", 0.0, 0.49, "Poisson's ratio of wheel and rail", default=0.3)
    pairs: tuple[ProfilePair, ProfilePair] = (ProfilePair(), ProfilePair())
    """Of wheel 1 and 2."""

    def __post_init__(self) -> None:
        check(self, "contact")
        for number, pair in enumerate(self.pairs, start=1):
            angle, at = pair.angle
            if angle > STEEPEST:
                raise InputError(
                    f"wheel_{number} touches its rail at an angle of {angle:.2f} rad, {1e3 * abs(at):.1f} mm "
                    f"{'inside' if at < 0 else 'outside'} the middle of the head, and the contact model is valid up to "
                    f"{STEEPEST:g} rad: give a smaller lateral_offset, or other profiles"
                )

    @property
    def contact_modulus(self) -> float:
        """E*, Pa."""
        return contact_modulus(self.youngs_modulus, self.poissons_ratio)

    def touch(self, wheel: int) -> float:
        """Where ``wheel`` (0 or 1) touches its rail, y from the middle of the head, m."""
        return OUTWARDS[wheel] * self.pairs[wheel].touch + 0.0  # no -0.0

    def rolling_circle(self, wheel: int) -> float:
        """Where the rolling circle of ``wheel`` is over its rail, y from the middle of the head, m."""
        return OUTWARDS[wheel] * self.pairs[wheel].shift + 0.0

    def separation(self, wheel: int, x: ArrayLike, y: ArrayLike) -> Real:
        """z_W + z_R of Eq. (9): distance between the undeformed surfaces that touch, m.

        ``x`` counts from below the axle and ``y`` from the middle of the rail's head, in m; they broadcast.
        """
        x, y = np.asarray(x, float), OUTWARDS[wheel] * np.asarray(y, float)
        pair = self.pairs[wheel]
        height = pair.wheel.height(y - pair.shift)
        radius = self.wheel_radius + np.where(np.isfinite(height), height, 0.0)
        rise: Real = x**2 / (radius + np.sqrt(radius**2 - x**2))
        return rise + pair.gap(y)


@dataclass(frozen=True, eq=False)
class Section:
    """Both profiles in the plane of the axle, touching, to be drawn."""

    y: Real
    """From the middle of the rail's head, positive to the left, (n,), m."""
    wheel: Real
    """Height of the tread over the top of the rail, (n,), m; NaN where the profile ends."""
    rail: Real
    """Height of the rail, likewise."""
    touch: tuple[float, float]
    """Where they touch: y and height, m."""
    rolling_circle: float
    """y of the rolling circle, m."""
    angle: float
    """Largest angle of the contact to the track plane, rad."""


def section(geometry: ContactGeometry, wheel: int, half_width: float = 0.075, step: float = 2e-4) -> Section:
    """Profiles of ``wheel`` (0 or 1) and its rail up to ``half_width``, m, from the middle of the rail's head."""
    pair = geometry.pairs[wheel]
    y = np.arange(-round(half_width / step), round(half_width / step) + 1, dtype=np.float64) * step
    outwards = OUTWARDS[wheel] * y
    rail, tread = pair.rail.height(outwards), -pair.wheel.height(outwards - pair.shift) - pair.least
    top = pair.fine[2].max()
    rail, tread = (np.where(np.isfinite(line), line - top, np.nan) for line in (rail, tread))
    at = float(pair.rail.height(pair.touch) - top)
    return Section(y, tread, rail, (geometry.touch(wheel), at), geometry.rolling_circle(wheel), pair.angle[0])
