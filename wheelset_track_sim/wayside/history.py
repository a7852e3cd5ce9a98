"""What a detector reads while a wheelset passes, exactly for its contact forces, by Bloch waves and reciprocity.

A wheel presses on the rail with F(t) at X(t). With the influence line R(X, omega) of a channel
(``track.influence``), which is in each bay b the row psi(x, omega) of the rail's transfer matrix from the middle of the
bay times a state y_b(omega), the spectrum of the reading is::

    R(omega) = integral F(t) R(X(t), omega) exp(-i omega t) dt = sum_b y_b . P_b
    P_b(omega) = sum_j F_j dt psi(x_j, omega) exp(-i omega t_j)         steps j while the wheel is in bay b

P_b has nothing to do with the detector, y_b nothing with the passage. Behind a gauge in its own bay y differs, and the
steps there have a P of their own; a step at the gauge is dealt out to both by its cell of dx. The halves of the track
are driven by (F_1 + F_2) / 2 and (F_1 - F_2) / 2, and rail 1 and 2 are their sum and difference.

Finite time. Frequencies are ``omega - i eta`` with ``exp(-eta T) = WRAP``: what comes round the time T of the transform
is smaller by that factor, so waves that decay slowly need no long T.

Forces. Those of ``LEAD`` bays before the first reading count, faded in over ``FADE`` bays more; before the first step
that is given its force is taken to hold. After the last reading that force fades out; the reading sees it through the
low pass alone, which looks ahead by some periods of its band.

Cost: one product of matrices with steps by frequencies, and one with bays by frequencies for each gauge. Tables of psi
are kept for the last speeds, states for the last detectors; lengths of the transform are few, so that speeds share
states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..runtime.arrays import Complex, Real
from ..runtime.one_core import on_one_core
from ..track.bloch import BlochTrack, bloch_track
from ..track.influence import InfluenceLine, Quantity, influence_line
from ..track.timoshenko import deflection_powers
from ..track.track import HALVES, Half, Track
from .detector import Detector, check_place

LEAD = 10
"""Bays before the first reading over which forces count."""
FADE = 4
"""Bays before those over which the static force is faded in; half as many after the last reading."""
WRAP = 1e-5
"""What is left of motion that comes round the transform."""
FLAT = 0.5
"""Share of the band that is read as it is; from there the low pass goes down to 0 at the band as a cosine: a step
overshoots by 4 % for one period of the band."""
PART = 256
"""Frequencies of a table."""


@dataclass(frozen=True, eq=False)
class WaysideReading:
    """Samples of all channels of a detector during one passage of a wheelset."""

    detector: Detector
    position: float
    """Of the detector, m."""
    first_step: int
    """Step at the first sample."""
    step_length: float
    """m"""
    times: Real
    """(samples,) since the first sample, s."""
    places: Real
    """(samples,) of the wheelset along the track, m."""
    values: Real
    """(samples, channels) in SI units."""
    forces: Real
    """(steps, 2) contact forces from the first to the last sample, N."""

    def __len__(self) -> int:
        return len(self.times)

    def channel(self, name: str) -> Real:
        """Samples of one channel; KeyError if there is none of that name."""
        for channel, values in zip(self.detector.channels, self.values.T, strict=True):
            if channel.name == name:
                return np.asarray(values, dtype=np.float64)
        raise KeyError(name)


def window(detector: Detector, track: Track, position: float, step_length: float) -> tuple[int, int]:
    """First and last step that a detector at ``position`` m reads, at steps of ``step_length`` m."""
    first, last = detector.ends(track)
    begin, end = position + first - detector.reach, position + last + detector.reach
    return math.floor(begin / step_length + 1e-6), math.ceil(end / step_length - 1e-6)


def first_that_counts(begin: int, track: Track, step_length: float) -> int:
    """First step whose force counts for a reading that begins at the step ``begin``."""
    steps = round(track.spacing / step_length)
    return (begin // steps - LEAD - FADE) * steps


@on_one_core
def wayside_reading(
    detector: Detector,
    track: Track,
    position: float,
    forces: ArrayLike,
    *,
    speed: ArrayLike,
    first_step: int = 0,
    step_length: float = 1e-3,
) -> WaysideReading:
    """Compute what a detector reads while a wheelset passes.

    Parameters
    ----------
    detector
        Channels, rate and band (``load_detector``).
    track
        Track whose supports are all the same.
    position
        Where the detector stands, m; sleepers stand at whole multiples of the spacing.
    forces
        Contact forces of wheel 1 and 2 at consecutive steps, (steps, 2), N, positive in compression. They should begin
        some bays before the detector; before them the first ones are taken to hold.
    speed
        Of all steps, or of each (steps,), m/s.
    first_step
        Number of the first step: it is at ``first_step * step_length``.
    step_length
        Length of a step, m; the sleeper spacing is a whole number of them.

    Returns
    -------
    WaysideReading
        Samples of all channels from ``detector.reach`` before the first channel to as far behind the last.

    Raises
    ------
    InputError
        If the detector cannot stand there, or the forces do not cover what it reads.

    Examples
    --------
    >>> track, detector = load_track("ballasted_60e1"), load_detector("shear_single")
    >>> reading = wayside_reading(detector, track, 6.0, [[98.1e3, 98.1e3]] * 8000, speed=20.0)
    >>> f"{reading.channel('bay_1_rail_1')[len(reading) // 2] / 1e3:.1f} kN"
    '98.1 kN'
    """
    forces = np.asarray(forces, dtype=np.float64)
    steps = round(track.spacing / step_length)
    if forces.ndim != 2 or forces.shape[1] != 2 or not np.isfinite(forces).all():
        raise InputError("forces are no finite numbers of shape (steps, 2): give those of wheel 1 and 2 at each step")
    if steps < 1 or abs(steps * step_length - track.spacing) > 1e-9 * track.spacing:
        raise InputError(f"step_length = {step_length:g} m does not divide the spacing of {track.spacing:g} m")
    speeds = np.broadcast_to(np.asarray(speed, dtype=np.float64), len(forces))
    if len(speeds) == 0 or not np.all(speeds > 0.0):
        raise InputError("speed is not above 0 m/s at every step: give one speed, or one a step")
    check_place(detector, track, position, float(speeds.min()) / step_length)
    begin, end = window(detector, track, position, step_length)
    if not first_step <= begin < end < first_step + len(forces):
        raise InputError(
            f"position = {position:g} m of detector {detector.name} is off the line that has been run: it reads from "
            f"{begin * step_length:g} to {end * step_length:g} m, and there are forces from "
            f"{first_step * step_length:g} to {(first_step + len(forces) - 1) * step_length:g} m"
        )
    run = _Run.around(begin, end, first_step, forces, speeds, steps, step_length, detector.rate)
    grid = _grid(run.duration, detector.rate, detector.band)
    spectra = _spectra(run, track, position, detector, grid)
    number = math.floor((run.times[end - run.first] - run.origin) * detector.rate + 1e-9) + 1
    times = np.arange(number) / detector.rate
    zero = round(run.origin * detector.rate)
    whole = np.fft.irfft(spectra, n=grid.samples, axis=1)[:, zero : zero + number] * detector.rate
    at = run.times[begin - run.first : end + 1 - run.first] - run.origin
    return WaysideReading(
        detector=detector,
        position=position,
        first_step=begin,
        step_length=step_length,
        times=times,
        places=np.interp(times, at, np.arange(begin, end + 1) * step_length),
        values=np.ascontiguousarray((whole * np.exp(grid.decay * (times + run.origin))).T),
        forces=forces[begin - first_step : end + 1 - first_step],
    )


class _Grid(NamedTuple):
    """Frequencies of a transform of ``samples`` at ``rate`` Hz up to ``band``."""

    samples: int
    rate: float
    band: float

    @property
    def decay(self) -> float:
        """Eta, 1/s."""
        return -math.log(WRAP) * self.rate / self.samples

    @property
    def frequencies(self) -> Complex:
        """(f,) Hz below the band, with eta in the imaginary part."""
        count = math.ceil(self.band * self.samples / self.rate)
        real = np.arange(count) * (self.rate / self.samples)
        return np.asarray(real - 1j * (self.decay / (2.0 * np.pi)), dtype=np.complex128)

    @property
    def low_pass(self) -> Real:
        """(f,) Weights."""
        beyond = np.clip((self.frequencies.real / self.band - FLAT) / (1.0 - FLAT), 0.0, 1.0)
        weights: Real = (1.0 + np.cos(np.pi * beyond)) / 2.0
        return weights


def _grid(duration: float, rate: float, band: float) -> _Grid:
    """Of the lengths 2^n and 3 2^n the shortest that has room."""
    samples = 64
    while samples < duration * rate:
        samples = samples * 3 // 2 if samples & (samples - 1) == 0 else samples // 3 * 4
    return _Grid(samples, rate, band)


class _Piece(NamedTuple):
    """Steps of one speed within whole bays."""

    speed: float
    start: float
    """Time at which a wheel with this speed is at the beginning of the first bay, s."""
    forces: Real
    """(2, bays, steps of a bay) N, of the halves of the track; 0 at steps that belong to other pieces."""


@dataclass(frozen=True, eq=False)
class _Run:
    """Forces of whole bays around a reading, faded in and out."""

    first: int
    """First step, at the beginning of a bay."""
    steps: int
    """Of a bay."""
    step_length: float
    times: Real
    """(all steps,) since the beginning of the transform, s."""
    origin: float
    """Time of the first sample: a whole number of samples."""
    forces: Real
    """(2, all steps) N, of the halves of the track."""
    speeds: Real
    """(all steps,) m/s"""

    @classmethod
    def around(
        cls,
        begin: int,
        end: int,
        first_step: int,
        forces: Real,
        speeds: Real,
        steps: int,
        step_length: float,
        rate: float,
    ) -> _Run:
        first = (begin // steps - LEAD - FADE) * steps  # ``first_that_counts``
        last = (end // steps + 1 + FADE // 2) * steps
        fade_in, fade_out = (begin // steps - LEAD) * steps, end
        at = np.arange(first, last)
        kept = np.clip(at, first_step, end) - first_step
        speed = speeds[kept]
        weight = np.interp(at, [first, fade_in, fade_out, last], [0.0, 1.0, 1.0, 0.0])
        taken = forces[kept].T * (1.0 - np.cos(np.pi * weight)) / 2.0
        passed = np.concatenate([[0.0], np.cumsum(step_length / speed[:-1])])
        before = passed[begin - first]
        origin = math.ceil(before * rate) / rate
        halves = np.stack([taken[0] + taken[1], taken[0] - taken[1]]) / 2.0
        return cls(first, steps, step_length, passed - before + origin, origin, halves, speed)

    @property
    def duration(self) -> float:
        """Up to the end, s."""
        return float(self.times[-1] + self.step_length / self.speeds[-1])

    @property
    def bays(self) -> int:
        """Number of bays."""
        return len(self.times) // self.steps

    def pieces(self) -> Iterator[_Piece]:
        """Parts of one speed each."""
        borders = [0, *(np.flatnonzero(np.diff(self.speeds)) + 1).tolist(), len(self.speeds)]
        for start, stop in pairwise(borders):
            forces = np.zeros_like(self.forces)
            forces[:, start:stop] = self.forces[:, start:stop]
            speed = float(self.speeds[start])
            at = float(self.times[start]) - start * self.step_length / speed
            yield _Piece(speed, at, forces.reshape(2, self.bays, self.steps))


class _Place(NamedTuple):
    """A place of a term within its bay."""

    bay: int
    x: float


def _place(x: float, spacing: float, whole: bool) -> _Place:
    bay = round(x / spacing) if whole else math.floor(x / spacing + 1e-9)
    return _Place(bay, 0.0 if whole else max(0.0, round(x - bay * spacing, 9)))


def _spectra(run: _Run, track: Track, position: float, detector: Detector, grid: _Grid) -> Complex:
    """Spectra (channels, f) of all channels."""
    parts = [
        (number, channel.rail, term, _place(position + term.x, track.spacing, channel.on_sleeper))
        for number, channel in enumerate(detector.channels)
        for term in channel.terms(track)
    ]
    first = run.first // run.steps
    cuts = sorted({place for *_, place in parts if place.x > 0.0})
    whole, tails = _passed(run, track, [_Place(bay - first, x) for bay, x in cuts], grid)
    lowest, highest = (pick(place.bay for *_, place in parts) for pick in (min, max))
    omega = 2.0 * np.pi * grid.frequencies
    found = np.zeros((len(detector.channels), omega.size), dtype=np.complex128)
    span = first - highest, first + run.bays - 1 - lowest
    halves: dict[tuple[Quantity, _Place], list[Complex]] = {}
    for number, rail, term, place in parts:
        key = term.quantity, place
        if key not in halves:
            lines = [_line(track, half, grid, term.quantity, place.x, *span) for half in HALVES]
            start = first - place.bay - span[0]
            halves[key] = [
                (line.before[start : start + run.bays] * passed).sum(axis=(0, 1))
                for line, passed in zip(lines, whole, strict=True)
            ]
            if place.x > 0.0:
                for read, line, passed in zip(halves[key], lines, tails[:, cuts.index(place)], strict=True):
                    read += ((line.behind - line.before[-span[0]]) * passed).sum(axis=0)
        even, odd = halves[key]
        found[number] += term.factor * (1j * omega) ** term.order * (even + odd if rail == 0 else even - odd)
    return found * grid.low_pass


def _passed(run: _Run, track: Track, cuts: list[_Place], grid: _Grid) -> tuple[Complex, Complex]:
    """P (2, bays, 4, f) of all bays for both halves, and (2, cuts, 4, f) of what is behind each cut in its bay."""
    steps, frequencies = run.steps, grid.frequencies
    cell = np.arange(steps) + 0.5
    behind = np.array([np.clip(cell - x / run.step_length, 0.0, 1.0) for _, x in cuts]).reshape(len(cuts), steps)
    rows = [*range(run.bays), *(bay for bay, _ in cuts)]
    total = np.zeros((2, len(rows), 4, frequencies.size), dtype=np.complex128)
    for piece in run.pieces():
        forces = np.concatenate([piece.forces, piece.forces[:, rows[run.bays :]] * behind], axis=1)
        dt = run.step_length / piece.speed
        bay_time = np.exp(-2j * np.pi * frequencies * (steps * dt))
        start = np.exp(-2j * np.pi * frequencies * piece.start) * dt
        phases = np.empty((run.bays, frequencies.size), dtype=np.complex128)
        for bay in range(run.bays):
            phases[bay] = start if bay == 0 else phases[bay - 1] * bay_time
        for low in range(0, frequencies.size, PART):
            table = _table(track, steps, run.step_length, piece.speed, grid, low)
            count = table.shape[2]
            product = forces.reshape(-1, steps) @ table.view(np.float64).reshape(steps, -1)
            moved = product.view(np.complex128).reshape(2, len(rows), 4, count)
            total[..., low : low + count] += moved * phases[rows, np.newaxis, low : low + count]
    return total[:, : run.bays], total[:, run.bays :]


@lru_cache(maxsize=16)
def _table(track: Track, steps: int, step_length: float, speed: float, grid: _Grid, low: int) -> Complex:
    """Rows psi exp(-i omega t), (steps, 4, frequencies), of a bay from t = 0 on, for ``PART`` from ``low`` on."""
    frequencies = grid.frequencies[low : low + PART]
    omega, half = 2.0 * np.pi * frequencies, track.spacing / 2
    powers = deflection_powers(track.rail, omega, half)
    s = np.asarray(np.arange(steps) * (step_length / half) - 1.0)
    psi = np.vander(s, len(powers), increasing=True) @ powers.transpose(0, 2, 1).reshape(len(powers), -1)
    turns = np.exp(-1j * omega * (np.arange(steps)[:, np.newaxis] * (step_length / speed)))
    table: Complex = psi.reshape(steps, 4, -1) * turns[:, np.newaxis]
    table.flags.writeable = False
    return table


@lru_cache(maxsize=24)
def _line(
    track: Track, half: Half, grid: _Grid, quantity: Quantity, place: float, first: int, last: int
) -> InfluenceLine:
    return influence_line(_waves(track, half, grid), half, quantity, place, first, last)


@lru_cache(maxsize=4)
def _waves(track: Track, half: Half, grid: _Grid) -> BlochTrack:
    return bloch_track(track, half, grid.frequencies)
