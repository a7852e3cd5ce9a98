"""Measured treads and rails, from a file."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
import scipy

from ..errors import InputError, warn
from ..inputs import shipped
from ..inputs.schema import quantity
from ..inputs.units import UNITS
from ..runtime.arrays import Real
from .samples import ACROSS, ALONG, HEIGHT, Samples, samples_of, taken
from .stretch import part_of, ramp, start
from .surface import RAILS, WHEELS, Patch, Surface, check_shape
from .turns import REMEDY, Drift, Turns, one_turn, seam_step, without_drift

GAP = 2.5
"""Distances between neighbouring samples above this many times the median are gaps."""
CLOSING = 0.2
"""Share of the circumference by which samples given in m may be longer or shorter than it: wheels wear."""
SMOOTHEST = 2e-7
"""Heights within less are no surface, m, but in another unit."""
FINEST = 64
"""Samples a step at most that a filter takes in."""


@dataclass(frozen=True)
class Profile:
    """Measured heights r(along) or r(along, across); only their deviations count.

    ``file`` is a text or NumPy file (``.npy``), a path or one that is shipped, with a column of positions along, and
    one of heights or one for each position across (``samples.taken``).
    A tread is taken once around, by angle or by length, which is then scaled to the circumference, and has its mean
    taken off. A rail begins at ``start``, has the straight line through it taken off, and rises and falls over
    ``ramp``. With ``repeat`` it repeats all along: its next beginning is one sample spacing after its last sample, and
    the period is scaled to the nearest whole number of steps. Waves shorter than two steps are filtered out first, so
    that they do not appear as longer ones.
    """

    type: ClassVar[str] = "profile"

    on: Literal["wheel_1", "wheel_2", "rail_1", "rail_2"]
    file: str
    along: Literal["rad", "deg", "m", "mm"] | None = None
    """Unit of positions along the surface, if the file does not state it; rails take m and mm."""
    height: Literal["m", "mm", "um"] | None = None
    """Unit of heights or radii, if the file does not state it."""
    across: Literal["m", "mm"] = "mm"
    """Unit of lateral positions."""
    gaps: Literal["refuse", "fill"] = "refuse"
    """What becomes of missing samples: ``fill`` interpolates between their neighbours."""
    angle: float = quantity("rad", -2 * np.pi, 2 * np.pi, "angle on the wheel of position 0", default=0.0)
    start: float = start()
    ramp: float = ramp()
    repeat: bool = False
    table: str = ""
    """Content of the file, a row a line; read from it if empty, so that a scenario and its bag need no other file."""
    column: str = ""
    """Name or number of the column of heights, if there are several."""
    turns: Turns = "refuse"
    """What becomes of several turns of a wheel: ``first`` takes one, ``average`` the mean of the whole ones."""
    drift: Drift = "keep"
    """``remove`` takes off what a sensor drifted over the turn of a wheel, or over a rail that repeats, so that the end
    meets the beginning."""

    def __post_init__(self) -> None:
        check_shape(self, (*WHEELS, *RAILS))
        for name, known in (("along", ALONG), ("height", HEIGHT), ("across", ACROSS)):
            if getattr(self, name) not in (*known, None):
                raise InputError(f"{name} = {getattr(self, name)!r} is not a known unit: give {', '.join(known)}")
        if not self.table:
            source = shipped.located("measured", self.file)
            found = taken(source, self.on, self.column, self.along, self.height, self.across)
            for name, value in zip(("table", "along", "height", "across"), found, strict=True):
                object.__setattr__(self, name, value)
        for name in ("along", "height"):
            if getattr(self, name) is None:
                raise InputError(f"{name} is missing: give the unit that {self.file} uses")
        if self.on in RAILS and self.along not in ACROSS:
            raise InputError(f"along = {self.along} applies to wheels only: give m or mm for {self.on}")
        if self.on in WHEELS and (self.start or self.repeat):
            raise InputError(f"start and repeat apply to rails only: leave them out for {self.on}, and give angle")
        if self.on in RAILS and self.angle:
            raise InputError(f"angle applies to wheels only: leave it out for {self.on}, and give start")
        if self.on in RAILS and self.turns != "refuse":
            raise InputError(f"turns applies to wheels only: leave it out for {self.on}")
        if self.on in RAILS and self.drift != "keep" and not self.repeat:
            raise InputError(f"drift applies to wheels, and to rails with repeat: leave it out for {self.on}")
        _ = self.samples

    @cached_property
    def samples(self) -> Samples:
        """Samples in m and rad, in their order along the surface, without gaps."""
        assert self.along is not None
        assert self.height is not None
        found = samples_of(self.table, self.file)
        along, values = found.along * UNITS[self.along].size, found.values * UNITS[self.height].size
        spread = float(np.nanmax(values) - np.nanmin(values)) if np.isfinite(values).any() else 0.0
        if 0.0 < spread < SMOOTHEST:
            warn(
                f"{self.file} has heights within {spread:.3g} m, smoother than any real surface: check height, "
                "their unit"
            )
        around = 2 * math.pi if self.along in ("rad", "deg") else 0.0
        if self.on in WHEELS and len(along) > 1:
            along, values = one_turn(along, values, around or None, self.turns, self.drift, self.file)
        along = along % around if around else along
        order = np.argsort(along, kind="stable")
        along, values, across = along[order], values[order], found.across
        if across is not None:
            order = np.argsort(across)
            across, values = across[order] * UNITS[self.across].size, values[:, order]
        found = _whole(Samples(along, values, across), around, self.gaps, self.file)
        return self._closed(found) if self.repeat else found

    def _closed(self, samples: Samples) -> Samples:
        """Samples of a rail that repeats, without drift if told; InputError if their end misses their beginning."""
        period = _period(samples.along)
        if self.drift == "remove":
            samples = samples._replace(values=without_drift(samples.along, samples.values, period))
        step = seam_step(samples.along, samples.values, period)
        if step:
            raise InputError(f"{self.file} repeats with a step of {step} from its end to its beginning: {REMEDY}")
        return samples

    @property
    def end(self) -> float:
        """Position where it ends, m."""
        return self.start + float(np.ptp(self.samples.along))

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface`` at lateral positions ``y``, m; beyond the samples across, those at the edge."""
        if surface.name in WHEELS:
            yield Patch(surface.at_angle(self.angle), self._across(self._around(surface), y))
            return
        first = surface.at(self.start)
        if self.repeat:
            heights = self._repeated(surface)
        else:
            heights = self._along(surface.dx)
            length = (len(heights) - 1) * surface.dx
            if 2 * self.ramp > length * (1 + 1e-9):
                raise InputError(
                    f"ramp = {self.ramp:g} m at both ends is more than the {length:g} m of {self.file}: "
                    f"give {length / 2:g} m at most"
                )
            share = part_of(surface, self.start, length, self.ramp).share
            heights = (heights - _line(heights)) * share[:, None]
        yield Patch(first, self._across(heights, y))

    def _around(self, surface: Surface) -> Real:
        """Heights at the steps of a tread, (steps, columns): the waves that steps can hold, each as it is.

        Raises InputError for samples given in m that are no turn of this wheel.
        """
        along, values = self.samples.along, self.samples.values
        if self.along in ACROSS:
            length = _period(along)
            if abs(length / surface.length - 1) > CLOSING:
                raise InputError(
                    f"{self.file} is {length:.4g} m long, and a turn of {surface.name} {surface.length:.4g} m: "
                    f"give one whole turn, within {CLOSING:.0%}, or positions as angles"
                )
            turn = along * (2 * math.pi / length)
        else:
            turn = along
        return _waves(turn, values, surface.steps)

    def _repeated(self, surface: Surface) -> Real:
        """Heights all along a rail, (steps, columns), that repeat after the samples and one spacing more.

        Raises InputError for a line that is no whole number of such periods.
        """
        along, values = self.samples.along, self.samples.values
        period = _period(along)
        steps = max(1, round(period / surface.dx))
        if surface.steps % steps:
            length = steps * surface.dx
            raise InputError(
                f"{self.file} repeats after {length:g} m, the line after {surface.length:g} m: "
                f"give a line_length of {math.ceil(surface.steps / steps) * length:.12g} m"
            )
        heights = _waves((along - along[0]) * (2 * math.pi / period), values, steps)
        return np.tile(heights, (surface.steps // steps, 1))

    def _along(self, dx: float) -> Real:
        """Heights at steps of a rail, (steps, columns)."""
        along, values = self.samples.along, self.samples.values
        finer = min(max(1, math.ceil(dx / np.median(np.diff(along)) - 1e-6)), FINEST)
        steps = math.floor(np.ptp(along) / dx + 1e-6) + 1
        even = along[0] + np.arange((steps - 1) * finer + 1) * (dx / finer)
        fine = scipy.interpolate.PchipInterpolator(along, values)(np.minimum(even, along[-1]))
        return fine if finer == 1 else np.asarray(scipy.signal.resample_poly(fine, 1, finer, axis=0, padtype="line"))

    def _across(self, heights: Real, y: Real) -> Real:
        """Heights of the columns at lateral positions ``y``, m."""
        if self.samples.across is None:
            return heights
        share = [np.interp(y, self.samples.across, one) for one in np.eye(len(self.samples.across))]
        return heights @ np.array(share)


def _period(along: Real) -> float:
    """Length after which samples that rise over it begin again: their extent and one spacing."""
    return float(np.ptp(along) + np.median(np.diff(along)))


def _waves(turn: Real, values: Real, steps: int) -> Real:
    """Heights (steps, columns) of a period from samples at phases ``turn`` (n,), rad: the waves that steps can hold."""
    count = len(turn)
    even = turn[0] + 2 * math.pi / count * np.arange(count)
    if np.abs(turn - even).max() > 1e-4 * 2 * math.pi / count:
        count = max(steps, min(math.ceil(2 * math.pi / np.diff(turn).min()), FINEST * steps))
        even = turn[0] + 2 * math.pi / count * np.arange(count)
        around = [turn[-3:] - 2 * math.pi, turn, turn[:3] + 2 * math.pi]
        ends = np.concatenate([values[-3:], values, values[:3]])
        values = scipy.interpolate.PchipInterpolator(np.concatenate(around), ends)(even)
    spectrum = np.fft.rfft(values - values.mean(), axis=0)[: (min(count, steps) + 1) // 2]
    turned = np.exp(-1j * np.arange(len(spectrum)) * turn[0])[:, None]
    return np.fft.irfft(spectrum * turned, steps, axis=0) * (steps / count)


def _whole(samples: Samples, around: float, gaps: str, file: str) -> Samples:
    """The samples with their gaps filled, or InputError; ``around`` is what they repeat after, 0 if they do not."""
    along, values = samples.along, samples.values.copy()
    distance = np.diff(along, append=along[0] + around) if around else np.diff(along)
    typical = float(np.median(distance))
    if not distance.min() > 1e-9 * typical:
        where = along[int(np.argmin(distance))]
        raise InputError(f"{file} has two samples at {where:g}: give one for each position, rising")
    missing = np.isnan(values)
    wide = np.flatnonzero(distance > GAP * typical)
    if gaps == "refuse" and (missing.any() or len(wide)):
        place = along[np.flatnonzero(missing.any(axis=1))[0]] if missing.any() else along[wide[0]]
        kind = "no value" if missing.any() else f"no sample for {distance[wide[0]]:.3g}"
        raise InputError(f"{file} has {kind} at {place:.4g} (rad or m): complete it, or give gaps: fill")
    if len(wide):
        inside = [np.arange(1, math.ceil(distance[at] / typical)) * typical + along[at] for at in wide]
        added = np.concatenate(inside)
        order = np.argsort(np.concatenate([along, added]), kind="stable")
        holes = np.full((len(added), values.shape[1]), np.nan)
        along, values = np.concatenate([along, added])[order], np.concatenate([values, holes])[order]
    for column in values.T:
        known = np.isfinite(column)
        if known.sum() < 4:
            raise InputError(f"{file} has {known.sum()} values in a column: give at least 4 in each")
        column[~known] = np.interp(along[~known], along[known], column[known], period=around or None)
    return Samples(along, values, samples.across)


def _line(values: Real) -> Real:
    """The straight line through the mean over the columns, (steps, 1)."""
    mean, x = values.mean(axis=1), np.linspace(-1.0, 1.0, len(values))
    return np.asarray(np.polynomial.Polynomial.fit(x, mean, 1)(x))[:, None]
