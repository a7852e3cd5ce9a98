"""How a run is cut into chunks and kept at a factor of real time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from ..schema import check, quantity


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


class Pacer:
    """A clock that runs at a factor of real time from the moment it is made."""

    def __init__(self, factor: float, simulated: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Start at the time ``simulated``, s; a factor of 0 is no pacing at all."""
        self._factor, self._clock = factor, clock
        self._origin = clock(), simulated

    def wait(self, simulated: float) -> float:
        """Time until ``simulated`` is due, s; negative if it is overdue, 0 without pacing."""
        if self._factor == 0:
            return 0.0
        started, first = self._origin
        return started + (simulated - first) / self._factor - self._clock()
