"""Detectors along a run: blocks in, a passage out as soon as the wheelset has passed a detector.

What a detector reads follows from the steps alone from which it reads, and from those before that count. Those are kept
while a detector needs them. So a passage has the same bits however a run is cut into blocks, live, from a bag, or
simulated again, as long as it holds these steps.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..sensors.reading import StepClock
from ..track.track import Track
from .detector import WaysideDetector
from .evaluation import WheelVerdict, evaluated
from .history import WaysideReading, first_that_counts, wayside_reading, window


@dataclass(frozen=True, eq=False)
class WaysidePassage:
    """What one detector gives when a wheelset has passed it."""

    topic: str
    reading: WaysideReading
    time: float
    """Of the first sample since step 0, s."""
    speed: float
    """At the first sample, m/s."""
    revision: int
    """In force at the first sample."""

    @property
    def first_step(self) -> int:
        """Step at the first sample."""
        return self.reading.first_step

    @property
    def step_period(self) -> float:
        """Time from sample to sample, s."""
        return 1.0 / self.reading.detector.rate

    @property
    def position(self) -> float:
        """Of the wheelset at the first sample, m."""
        return float(self.reading.places[0])

    @cached_property
    def verdicts(self) -> tuple[WheelVerdict, WheelVerdict]:
        """On the wheels on rail 1 and on rail 2."""
        return evaluated(self.reading)


@dataclass(frozen=True, eq=False)
class _Steps:
    """Steps that are needed yet, one entry each."""

    first: int
    forces: Real
    time: Real
    speed: Real
    revision: Real

    @classmethod
    def at_rest(cls, first: int, end: int, speed: float) -> _Steps:
        """Without forces."""
        nothing = np.zeros(end - first)
        return cls(first, np.zeros((end - first, 2)), nothing, speed + nothing, nothing)

    @property
    def end(self) -> int:
        return self.first + len(self.forces)

    def followed_by(self, other: _Steps) -> _Steps:
        names = ("forces", "time", "speed", "revision")
        return _Steps(self.first, *(np.concatenate([getattr(self, name), getattr(other, name)]) for name in names))

    def since(self, step: int) -> _Steps:
        cut = min(max(step - self.first, 0), len(self.forces))
        return _Steps(self.first + cut, self.forces[cut:], self.time[cut:], self.speed[cut:], self.revision[cut:])


class WaysideWatch:
    """Detectors beside the track of one run.

    Parameters
    ----------
    standing
        The detectors.
    track
        Track with equal supports.
    step_length
        Length of a step, m.
    speed
        Speed, m/s, for which tables are made at once; without, the first passage takes a second longer than others.
    """

    def __init__(
        self,
        standing: Sequence[WaysideDetector],
        track: Track,
        step_length: float,
        *,
        speed: float | None = None,
    ) -> None:
        self._track, self._dx, self._clock = track, step_length, StepClock()
        ends = [window(each.detector, track, each.position, step_length) for each in standing]
        order = sorted(range(len(standing)), key=lambda index: ends[index][1])
        self._waiting = [(standing[index], *ends[index]) for index in order]
        self._steps: _Steps | None = None
        for each, begin, end in self._waiting:
            if speed is not None:
                nothing = _Steps.at_rest(begin, end + 1, speed)
                self._passage(nothing, each, begin)

    def push(self, block: SampleBlock) -> list[WaysidePassage]:
        """Passages that are complete with a block; after a gap in the steps, what counts begins anew."""
        if not self._waiting:
            return []
        ones = np.ones(len(block))
        new = _Steps(
            block.first_step, block.forces, self._clock.times(block), block.speed * ones, block.revision * ones
        )
        steps = self._steps
        steps = new if steps is None or steps.end != new.first else steps.followed_by(new)
        passed = [waiting for waiting in self._waiting if waiting[2] < steps.end]
        self._waiting = self._waiting[len(passed) :]
        found = [self._passage(steps, each, begin) for each, begin, _ in passed if steps.first <= begin]
        needed = [first_that_counts(begin, self._track, self._dx) for _, begin, _ in self._waiting]
        self._steps = steps.since(min(needed, default=steps.end))
        return found

    def _passage(self, steps: _Steps, standing: WaysideDetector, begin: int) -> WaysidePassage:
        part = steps.since(first_that_counts(begin, self._track, self._dx))
        reading = wayside_reading(
            standing.detector,
            self._track,
            standing.position,
            part.forces,
            speed=part.speed,
            first_step=part.first,
            step_length=self._dx,
        )
        at = begin - part.first
        return WaysidePassage(
            standing.topic, reading, float(part.time[at]), float(part.speed[at]), int(part.revision[at])
        )


def passages(
    standing: Sequence[WaysideDetector], track: Track, step_length: float, blocks: Iterable[SampleBlock]
) -> Iterator[WaysidePassage]:
    """Passages of a run's blocks, in the order in which the detectors are passed."""
    watch = WaysideWatch(standing, track, step_length)
    for block in blocks:
        yield from watch.push(block)
