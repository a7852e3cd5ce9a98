"""What a damage would have made of a measurement: simulated signals of one observation.

A simulation at one speed, with the damage's centre meeting the rail at one place of the bay, is a curve over the time
since that hit. The observation is this curve, moved in time by a lag, times a gain::

    y(t) = g f(t - lag; damage, place, speed)

The speed is uncertain by a few parts in a thousand. In the time since each hit the signal changes little with it, for
wheelset and track answer in time, and not over length. So f is interpolated linearly between two speeds, which are
simulated, in the time since the last hit.

Where the track is not what the model has, f changes as well: by a parabola in the stiffness and in the damping of pads
and ballast each, through simulations on tracks with less and with more of it.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ..irregularities import Irregularity
from ..runtime.arrays import Real
from ..runtime.progress import Progress, unreported
from ..samples.block import SampleBlock
from ..samples.decimation import REACH
from ..samples.resampling import FINE, response_table
from ..scenario import WHEELS, Scenario
from ..sensors.kinds import AxleBoxAcceleration, Sensor
from ..simulation.models import Models, load_models
from ..simulation.passages import Passages
from ..track.track import Track
from .observation import Observation

MARGIN = 0.25
"""Track of a simulation before the first hit, and behind what is compared, m."""
SPAN = 2.0
"""Speeds that are simulated are this many standard deviations below and above the given one."""
EARLIER = 4
"""Turns with hits before the first that a signal of the wheelset shows: bending of the axle rings on, and loses two
fifths from turn to turn."""
CLOSER = 0.05
"""Share of that distance at which speeds are simulated once the speed is known."""
KEPT = 256
"""Curves that are kept."""


@dataclass(frozen=True)
class TrackPart:
    """A property of the track that is uncertain."""

    name: str
    part: str
    field: str

    def scaled(self, track: Track, factor: float) -> Track:
        """The track with it multiplied by a factor."""
        part = getattr(track, self.part)
        changed = dataclasses.replace(part, **{self.field: factor * getattr(part, self.field)})
        return dataclasses.replace(track, **{self.part: changed})


TRACK_PARTS = tuple(
    TrackPart(f"{part} {field}", part, field) for part in ("pad", "ballast") for field in ("stiffness", "damping")
)


def uncertain_parts(track: Track) -> tuple[TrackPart, ...]:
    """Parts of a track whose properties are uncertain: slab track has no ballast."""
    return tuple(part for part in TRACK_PARTS if getattr(track, part.part) is not None)


class TrackModels:
    """Models of a scenario, and of tracks that differ from it in one property; built when they are first used."""

    def __init__(self, scenario: Scenario, error: float, progress: Progress = unreported) -> None:
        """``error`` is the standard deviation of each property as a share of it."""
        self.scenario, self.error, self._progress = scenario, error, progress
        self.parts = uncertain_parts(scenario.track) if error > 0 else ()
        self._built: dict[tuple[int, tuple[Sensor, ...]], Models] = {}

    def scenario_of(self, number: int, sensors: tuple[Sensor, ...]) -> Scenario:
        """Scenario of track ``number``: 0 is the given one.

        Track ``n`` has a standard deviation more of property ``n - 1``, track ``-n`` a standard deviation less.
        """
        track = self.scenario.track
        if number:
            error = self.error if number > 0 else -self.error
            track = self.parts[abs(number) - 1].scaled(track, 1.0 + error)
        return dataclasses.replace(self.scenario, track=track, sensors=sensors)

    def models(self, number: int, sensors: tuple[Sensor, ...]) -> Models:
        """Models of that scenario."""
        key = number, sensors
        if key not in self._built:
            self._built[key] = load_models(self.scenario_of(number, sensors), self._progress, tables="smooth")
        return self._built[key]


@dataclass(frozen=True, eq=False)
class PassageCurve:
    """Signals over the time since the hit that counts, s, of a simulation at one speed."""

    spline: CubicSpline
    turn: float
    """Time of a turn of the wheel, s: between two hits."""
    speed: float
    peak: float
    """Time of the largest deviation of the first signal, s."""


class Forward:
    """Simulated signals of one observation."""

    def __init__(self, observation: Observation, tracks: TrackModels) -> None:
        self.observation, self._tracks = observation, tracks
        scenario = tracks.scenario
        self.circumference = scenario.steps_per_revolution * scenario.step_length
        self.bay = scenario.track.spacing
        self._radius = self.circumference / (2 * math.pi)
        first, peak, end = observation.window(self.circumference)
        self.part = slice(first, end)
        self.time = observation.time[first:end] - observation.time[peak]
        """(n,) since the peak, s."""
        self.values = observation.values[first:end]
        before, after = -self.time[0] * observation.speed, self.time[-1] * observation.speed
        self.earlier = math.floor(before / self.circumference) + EARLIER if observation.on_wheelset else 0
        """Hits that are simulated before the one that counts."""
        self.sensors = _sensors(observation)
        reach = 1.0 + SPAN * observation.speed_error
        self._before = MARGIN if observation.on_wheelset else min(before * reach + MARGIN, scenario.reference_position)
        self._after = self.bay + self.earlier * self.circumference + after * reach + MARGIN
        width = SPAN * observation.speed_error
        self.speeds = tuple(observation.speed * (1.0 + share) for share in ((-width, width) if width else (0.0,)))
        """That are simulated, m/s."""
        self.centre, self.width = 0.0, SPAN
        """Of the simulated speeds, in standard deviations of the speed."""
        self._passages: dict[int, Passages] = {}
        self.simulated = 0
        """Passages simulated so far."""
        self._kept: dict[Any, PassageCurve] = {}

    def passages(self, track: int) -> Passages:
        """Passages on a track; see ``TrackModels``."""
        if track not in self._passages:
            tracks = self._tracks
            scenario = tracks.scenario_of(track, self.sensors)
            self._passages[track] = Passages(
                scenario, models=tracks.models(track, self.sensors), before=self._before, after=self._after
            )
        return self._passages[track]

    def angle(self, place: float) -> float:
        """Angle of a defect that meets the rail at ``place`` of a bay, m, in the hit that counts, rad."""
        return ((place - self.earlier * self.circumference) % self.bay) / self._radius

    def curve(self, damage: Irregularity | None, place: float, speed: int, track: int = 0) -> PassageCurve:
        """Curve of a damage whose ``angle`` is that of ``place``, at one of ``speeds``, on a track; None: no damage."""
        key = damage, place, speed, track
        if key not in self._kept:
            self._kept[key] = self._curve(*key)
            while len(self._kept) > KEPT:
                self._kept.pop(next(iter(self._kept)))
        return self._kept[key]

    def _curve(self, damage: Irregularity | None, place: float, speed: int, track: int) -> PassageCurve:
        self.simulated += 1
        passages, v = self.passages(track), self.speeds[speed]
        dx = passages.scenario.step_length
        defects = () if damage is None else (damage,)
        block = passages.run(defects, speed=v, axle_load=self.observation.axle_load)
        hit = self._before + round(self.angle(place) * self._radius / dx) * dx + self.earlier * self.circumference
        signals = low_passed(self._signals(block), self.observation.period * v / dx)
        time = (np.arange(len(signals)) * dx - hit) / v
        near = np.abs(time) < 0.3 / v
        away = np.abs(signals[near, 0] - np.median(signals[:, 0]))
        peak = float(time[near][away.argmax()])
        return PassageCurve(CubicSpline(time, signals, axis=0), self.circumference / v, v, peak)

    def _signals(self, block: SampleBlock) -> Real:
        """Signals (n, channels) from which the observed one follows."""
        wheel, signal = WHEELS.index(self.observation.wheel), self.observation.signal
        if signal == "force":
            return block.forces[:, wheel : wheel + 1]
        return block.sensors[self.sensors[0].topic][:, wheel : wheel + 1]

    def at(self, curve: PassageCurve, lag: float, speed: float, derivative: int = 0) -> Real:
        """Observed signal (n,) by a curve, at the true ``speed``; or its derivative with respect to minus ``lag``."""
        since = self.time - lag
        turn = self.circumference / speed
        hits = np.floor((since + 0.1 / speed) / turn) if self.observation.on_wheelset else np.zeros(len(since))
        at = np.clip(since - hits * turn + hits * curve.turn, curve.spline.x[0], curve.spline.x[-1])
        found: Real = curve.spline(at, derivative)[:, 0]
        return found

    def narrow(self, deviation: float) -> None:
        """Simulate at speeds close to one that is ``deviation`` standard deviations off, from now on.

        What rings on from earlier turns meets a hit in a phase that depends on the speed, and so not linearly.
        """
        if len(self.speeds) > 1:
            self.centre, self.width = deviation, CLOSER * SPAN
            given = self.observation
            self.speeds = tuple(
                given.speed * (1.0 + given.speed_error * (deviation + side)) for side in (-self.width, self.width)
            )
            self._kept.clear()

    def weights(self, deviation: float) -> list[tuple[int, float]]:
        """Which speeds count how much where the speed is ``deviation`` standard deviations off."""
        if len(self.speeds) == 1:
            return [(0, 1.0)]
        share = 0.5 + 0.5 * (deviation - self.centre) / self.width
        return [(0, 1.0 - share), (1, share)]

    def nearest(self, deviation: float) -> int:
        """The nearer of the simulated speeds."""
        return int(len(self.speeds) > 1 and deviation >= self.centre)


def _sensors(observation: Observation) -> tuple[Sensor, ...]:
    """From which the observed signal follows."""
    return (AxleBoxAcceleration(),) if observation.signal == "box" else ()


def low_passed(signals: Real, step: float) -> Real:
    """Signals (n, channels) without what sampling at every ``step`` steps (above 1) cannot show."""
    if step <= 1.0 + 1e-9:
        return signals
    half = math.ceil(REACH * step)
    distance = np.abs(np.arange(-half, half + 1)) / step
    kernel = np.interp(distance, np.append(np.linspace(0.0, REACH, FINE * REACH + 1), REACH + 1e-9), response_table())
    kernel /= kernel.sum()
    padded = np.pad(signals, ((half, half), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, kernel, "valid") for column in padded.T], axis=-1)
