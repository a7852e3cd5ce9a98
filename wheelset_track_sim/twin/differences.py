"""Difference of two runs, sample by sample, in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..samples.block import SampleBlock


@dataclass(frozen=True)
class SamplePlace:
    """A sample."""

    step: int
    time: float
    """In the recorded run, s."""
    position: float
    """m"""


@dataclass(frozen=True)
class Difference:
    """Of one quantity, over a run."""

    largest: float
    """N or Pa."""
    signal: str
    """Signal with the largest difference, such as ``wheel_1`` or ``A1 yy``."""
    at: SamplePlace
    """SamplePlace of the largest difference."""
    first: SamplePlace
    """The first sample with a difference."""
    last_beyond: SamplePlace | None
    """The last sample with more than the limit; None if there is none."""


class RunDifferences:
    """Collects the difference of some signals over consecutive blocks."""

    def __init__(self, signals: tuple[str, ...], limit: float) -> None:
        """``limit`` is the largest difference that counts as agreement, in the unit of the signals."""
        self._signals, self._limit = signals, limit
        self._found: Difference | None = None

    @property
    def found(self) -> Difference | None:
        """The difference so far; None if all samples are the same, bit by bit."""
        return self._found

    def push(self, block: SampleBlock, before: int, ours: Real, theirs: Real) -> None:
        """Compare samples (n, signals) of both runs, from sample ``before`` of the recorded ``block`` on."""
        unequal = unequal_bits(ours, theirs)
        if not unequal.any():
            return

        def place(row: int) -> SamplePlace:
            step = before + int(row)
            time = block.time + step * block.step_period
            return SamplePlace(block.first_step + step, time, block.position + step * block.speed * block.step_period)

        size = np.where(unequal, np.nan_to_num(np.abs(ours - theirs), nan=np.inf), 0.0)
        row, column = np.unravel_index(int(size.argmax()), size.shape)
        beyond = np.flatnonzero((size > self._limit).any(axis=1))
        here = Difference(
            float(size[row, column]),
            self._signals[column],
            place(int(row)),
            place(int(np.flatnonzero(unequal.any(axis=1))[0])),
            place(int(beyond[-1])) if len(beyond) else None,
        )
        self._found = _joined(self._found, here) if self._found else here


def unequal_bits(ours: Real, theirs: Real) -> NDArray[np.bool_]:
    """Where numbers of two arrays differ in any bit."""
    unequal: NDArray[np.bool_] = _bits(ours) != _bits(theirs)
    return unequal


def _bits(values: Real) -> NDArray[np.uint64]:
    """Numbers by their bits: a zero has two signs, and NaN is the same as itself."""
    return np.ascontiguousarray(values, np.float64).view(np.uint64)


def _joined(before: Difference, after: Difference) -> Difference:
    larger = after if after.largest > before.largest else before
    return Difference(larger.largest, larger.signal, larger.at, before.first, after.last_beyond or before.last_beyond)
