"""A part of a run, and the search for its beginning in bags with an index."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..runtime.arrays import Real
from ..samples.block import SampleBlock


@dataclass(frozen=True)
class RunWindow:
    """Samples from a step and a time on, and before others."""

    start: float = -math.inf
    """Simulated time, s."""
    stop: float = math.inf
    """s"""
    first_step: int = 0
    end_step: int | None = None

    def __post_init__(self) -> None:
        if math.isnan(self.start) or math.isnan(self.stop) or self.start >= self.stop:
            raise InputError(
                f"start = {self.start:g} s and stop = {self.stop:g} s select nothing: give a start before stop"
            )
        if self.first_step < 0 or (self.end_step is not None and self.end_step <= self.first_step):
            raise InputError(
                f"steps from {self.first_step} to {self.end_step} select nothing: give a first_step from 0 on, and "
                "an end_step above it"
            )

    def __str__(self) -> str:
        end = "" if self.end_step is None else f" to {self.end_step - 1}"
        return f"from {self.start:g} s to {self.stop:g} s, in steps from {self.first_step}{end}"

    @property
    def whole(self) -> bool:
        """Whether it is the whole run."""
        return self == EVERYTHING

    def after(self, step: int, time: float) -> bool:
        """Whether it begins after a sample."""
        return step < self.first_step or time < self.start

    def over(self, step: int, time: float) -> bool:
        """Whether it has ended before a sample."""
        return time >= self.stop or (self.end_step is not None and step >= self.end_step)

    def holds(self, steps: NDArray[np.uint64], times: Real) -> NDArray[np.bool_]:
        """Which samples are in it."""
        held: NDArray[np.bool_] = (steps >= self.first_step) & (times >= self.start) & (times < self.stop)
        return held if self.end_step is None else held & (steps < self.end_step)

    def touches(self, block: SampleBlock) -> bool:
        """Whether some samples of a block are in it."""
        last = len(block) - 1
        ends = block.first_step + last * block.decimation, block.time + last * block.step_period
        return self.meets(block.first_step, block.time, *ends)

    def meets(self, step: int, time: float, last_step: int, last_time: float) -> bool:
        """Whether some samples are in it, from a step and its time to the last ones."""
        return not self.over(step, time) and not self.after(last_step, last_time)


EVERYTHING = RunWindow()


def first_chunk(count: int, window: RunWindow, sample: Callable[[int], tuple[int, float] | None]) -> int:
    """Number of a chunk at or before the beginning of the window, found by bisection.

    ``sample`` returns step and time of the first sample in a chunk; None if it has none.
    """
    best, low, high = 0, 0, count
    while high - low > 1:
        middle = looked = (low + high) // 2
        while (found := sample(looked)) is None and looked - 1 > low:
            looked -= 1
        if found is None:
            low = middle
        elif window.after(*found):
            best, low = looked, middle
        else:
            high = looked
    return best
