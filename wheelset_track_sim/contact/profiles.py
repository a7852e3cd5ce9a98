"""Lateral profiles of wheels and rails.

Both sides of the track have the same: ``y`` counts outwards, to the field side, from the rolling circle of a wheel and
from the middle of a rail's head. A height is positive where there is more material: that of a rail counts upwards, that
of a wheel is what its radius is larger than on the rolling circle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike

from ..errors import InputError
from ..runtime.arrays import Real

FEWEST, MOST = 20, 5000
"""Points of a profile."""
WIDEST = 2e-3
"""Largest distance of two neighbouring points, m: a contact is 10 mm wide."""
LEAST_REACH = 0.025
"""Points reach at least so far to either side, m: what is beyond seldom bears."""
STEEP = 0.25
"""Slope up to which points are smoothed together: no contact is solved on what is steeper (``geometry.STEEPEST``)."""


class LateralProfile(Protocol):
    """A lateral profile."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last y that have a surface, m; may be infinite."""
        ...

    @property
    def open_ends(self) -> tuple[bool, bool]:
        """Whether the body goes on, unknown, where the span ends."""
        ...

    def height(self, y: ArrayLike) -> Real:
        """Height at ``y``, m; minus infinity outside the span."""
        ...


@dataclass(frozen=True)
class Straight:
    """A cylinder, or a cone whose radius falls to the field side; without flange."""

    slope: float = 0.0
    """Fall of the radius by y: 1/40 of a usual cone."""

    @property
    def span(self) -> tuple[float, float]:
        """Endless."""
        return -np.inf, np.inf

    @property
    def open_ends(self) -> tuple[bool, bool]:
        """None."""
        return False, False

    def height(self, y: ArrayLike) -> Real:
        """Height at ``y``, m."""
        return -self.slope * np.asarray(y, float)


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

    @property
    def span(self) -> tuple[float, float]:
        """Width of the head."""
        return -self.half_width, self.half_width

    @property
    def open_ends(self) -> tuple[bool, bool]:
        """None: the sides of the head follow."""
        return False, False

    def height(self, y: ArrayLike) -> Real:
        """Height over the top at ``y``, m."""
        return -self.drop(y)

    def drop(self, y: ArrayLike) -> Real:
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


@dataclass(frozen=True, eq=False)
class Points:
    """A measured profile, or one sampled from a drawing.

    The running surface, as far as it is flatter than ``STEEP``, is a cubic smoothing spline through the points, whose
    stiffness generalised cross-validation decides (Craven and Wahba, Numerische Mathematik 31 (1979) 377-403): points
    without noise are met, and noise that differs from point to point is taken out. What is steeper, flange root and
    gauge corner, is joined by straight lines.
    """

    y: Real
    """Rising, (n,), m."""
    z: Real
    """Heights, (n,), m."""
    noisy: bool = True
    """False for points that are exact: all are met, by a spline all along."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Points) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @cached_property
    def _content(self) -> tuple[bytes, bytes, bool]:
        return self.y.tobytes(), self.z.tobytes(), self.noisy

    def __post_init__(self) -> None:
        y, z = self.y, self.z
        if y.ndim != 1 or y.shape != z.shape or not FEWEST <= len(y) <= MOST:
            raise InputError(
                f"a profile of {y.size} y and {z.size} z cannot be used: give equally many of both, from {FEWEST} "
                f"to {MOST}"
            )
        if not (np.isfinite(y).all() and np.isfinite(z).all()):
            number = int(np.flatnonzero(~(np.isfinite(y) & np.isfinite(z)))[0])
            raise InputError(f"point {number} of a profile is not finite: leave it out")
        apart = np.diff(y)
        if not (apart > 0.0).all():
            number = int(np.flatnonzero(apart <= 0.0)[0]) + 1
            raise InputError(
                f"y = {y[number]:g} m of point {number} does not rise: give points from the gauge side to the field "
                "side, without overhanging parts"
            )
        if apart.max() > WIDEST:
            number = int(apart.argmax())
            raise InputError(
                f"points {number} and {number + 1} are {apart[number]:.3g} m apart: give points at most {WIDEST:g} "
                "m apart"
            )
        if y[0] > -LEAST_REACH or y[-1] < LEAST_REACH:
            raise InputError(
                f"a profile from y = {y[0]:g} to {y[-1]:g} m does not cover the running surface: give points from "
                f"{-LEAST_REACH:g} to {LEAST_REACH:g} m at least"
            )

    @property
    def span(self) -> tuple[float, float]:
        """From the first point to the last."""
        return float(self.y[0]), float(self.y[-1])

    @property
    def open_ends(self) -> tuple[bool, bool]:
        """Where the end is not steep."""
        slope = np.abs(np.diff(self.z) / np.diff(self.y))
        return bool(slope[0] < 1.0), bool(slope[-1] < 1.0)

    @cached_property
    def running_surface(self) -> slice:
        """The points around the middle up to where the profile is steep over a length of ``WIDEST``."""
        chord = np.abs(np.interp(self.y + WIDEST, self.y, self.z) - np.interp(self.y, self.y, self.z)) / WIDEST
        steep = chord > STEEP
        inside = np.flatnonzero(steep & (self.y < 0.0)), np.flatnonzero(steep & (self.y >= 0.0))
        first = int(inside[0][-1]) + 1 if len(inside[0]) else 0
        last = int(inside[1][0]) + 1 if len(inside[1]) else len(self.y)
        return slice(first, last)

    @cached_property
    def _spline(self) -> scipy.interpolate.BSpline:
        part = self.running_surface if self.noisy else slice(None)
        y, z = 1e3 * self.y[part], 1e3 * self.z[part]  # in mm, in which neither is far from 1
        splines = scipy.interpolate
        return splines.make_smoothing_spline(y, z) if self.noisy else splines.make_interp_spline(y, z, k=3)

    def height(self, y: ArrayLike) -> Real:
        """Height at ``y``, m."""
        y = np.asarray(y, float)
        part = self.y[self.running_surface] if self.noisy else self.y
        smooth = np.asarray(1e-3 * self._spline(1e3 * np.clip(y, part[0], part[-1])))
        rest = np.interp(y, self.y, self.z, left=-np.inf, right=-np.inf)
        return np.where((y >= part[0]) & (y <= part[-1]), smooth, rest)


def inclined(rail: LateralProfile, tangent: float) -> LateralProfile:
    """A rail leaning to the middle of the track by ``tangent``, such as 1/40, about y = 0 at the height of its top.

    Its heights may count from anywhere.
    """
    if tangent == 0.0:
        return rail
    low, high = rail.span
    flat = np.linspace(low, high, 2 * int((high - low) / 2e-4) + 1)
    z = rail.height(flat)
    z = z - z.max(initial=-np.inf, where=np.isfinite(z))
    cosine = 1.0 / np.hypot(1.0, tangent)
    across, up = cosine * (flat - tangent * z), cosine * (z + tangent * flat)
    middle = len(flat) // 2
    # The side of a head may overhang now: no wheel gets there.
    back = np.flatnonzero(np.diff(across) <= 1e-6)
    first = int(back[back < middle].max(initial=-1)) + 1
    last = int(back[back >= middle].min(initial=len(flat) - 1)) + 1
    return Points(across[first:last], up[first:last], noisy=False)


def gauge_face(rail: LateralProfile, below: float = 0.014) -> float:
    """Where the inner side of a rail is ``below`` its top, y in m; the gauge is measured there (EN 13848-1).

    Raises InputError if the profile ends above that.
    """
    y = np.arange(int(rail.span[0] * 1e5), 1) * 1e-5
    depth = rail.height(np.arange(-2000, 2001) * 1e-5).max() - rail.height(y)
    if not depth.max(initial=0.0, where=np.isfinite(depth)) >= below:
        raise InputError(
            f"the rail's profile ends {depth[np.isfinite(depth)].max():.3g} m below its top, and the gauge is measured "
            f"{below:g} m below: give points down to there, or no gauge"
        )
    return float(y[depth >= below][-1])
