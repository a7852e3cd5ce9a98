"""Cut a run into chunks, and keep it at a factor of real time."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Protocol

from ..inputs.schema import check, quantity


@dataclass(frozen=True)
class Pace:
    """Length of a chunk, speed of the clock, end of the run; all in simulated time."""

    chunk_duration: float = quantity("s", 0.001, 1.0, "the simulated time of one chunk", default=0.05)
    real_time_factor: float = quantity(
        "", 0.0, 1000.0, "the simulated time over the elapsed time, 0 for as fast as possible,", default=1.0
    )
    duration: float = quantity("s", 0.0, 1e6, "the simulated time after which the run ends, 0 for never,", default=0.0)

    def __post_init__(self) -> None:
        check(self)

    def steps(self, simulated: float, step_period: float) -> int:
        """Steps of the chunk that begins at the time ``simulated``, s since step 0; 0 at the end of the run."""
        steps = max(1, round(self.chunk_duration / step_period))
        if self.duration == 0:
            return steps
        return max(0, min(steps, round((self.duration - simulated) / step_period)))


class Clock(Protocol):
    """The clock that paces a run; it may stop, and it may be set."""

    @property
    def epoch(self) -> int:
        """Another number each time the clock is set, which invalidates earlier schedules."""
        ...

    def now(self) -> float:
        """Time, s."""
        ...

    def sleep(self, due: float, wake: threading.Event) -> None:
        """Return when it is ``due``, when ``wake`` is set, or earlier."""
        ...


class SteadyClock:
    """Elapsed time of the machine, which cannot be set."""

    epoch = 0

    def now(self) -> float:
        """Time, s."""
        return time.monotonic()

    def sleep(self, due: float, wake: threading.Event) -> None:
        """Return when it is ``due``, or when ``wake`` is set."""
        wake.wait(max(0.0, due - self.now()))


class Pacer:
    """A schedule at a factor of a clock, from now on; it starts again when the clock is set."""

    def __init__(self, factor: float, simulated: float, clock: Clock) -> None:
        """Start at the simulated time ``simulated``, s; a factor of 0 is no pacing."""
        self._factor, self._clock = factor, clock
        self._reached = simulated
        self._begin()

    def wait(self, simulated: float) -> float:
        """Time of the clock until ``simulated`` is due, s; negative if it is overdue, 0 without pacing."""
        if self._factor == 0:
            return 0.0
        if self._epoch != self._clock.epoch:
            self._begin()
        wait = self._due(simulated) - self._clock.now()
        if wait <= 0:
            self._reached = simulated
        return wait

    def sleep(self, simulated: float, wake: threading.Event) -> None:
        """Return when ``simulated`` is due, when ``wake`` is set, or earlier."""
        self._clock.sleep(self._due(simulated), wake)

    def now(self) -> float:
        """Simulated time that is due now, s; without pacing, the time of the start."""
        started, first = self._origin
        return first + (self._clock.now() - started) * self._factor

    def _begin(self) -> None:
        self._epoch = self._clock.epoch
        self._origin = self._clock.now(), self._reached

    def _due(self, simulated: float) -> float:
        started, first = self._origin
        return started + (simulated - first) / self._factor
