"""A run of any length as a bounded number of minima and maxima, so that no peak is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..runtime.arrays import Real
from .samples import SampleSeries

CAPACITY = 2**15
"""Most bins of a run: twice as many as a wide screen has columns of pixels, ten times over."""


@dataclass(frozen=True, eq=False)
class Bins:
    """Minima and maxima over ``size`` consecutive samples each; the last bin may hold fewer."""

    size: int
    first_step: int
    time: Real
    """Of the first sample of each bin, (bins,), s."""
    low: Real
    """(bins, columns)"""
    high: Real
    """(bins, columns)"""

    def __len__(self) -> int:
        return len(self.time)


class Envelope:
    """Collects the bins of a run: full resolution at first, half of it whenever the bins are all in use.

    Samples that are NaN are not there; a bin without any is NaN.
    """

    def __init__(self, capacity: int = CAPACITY) -> None:
        """``capacity`` is the largest number of bins, even."""
        self._capacity = capacity
        self._size = 1
        self._count = 0
        self._first_step = 0
        self._time = np.zeros(capacity)
        self._low = self._high = np.zeros((capacity, 0))
        self._rest: SampleSeries | None = None

    def push(self, samples: SampleSeries) -> None:
        """Add the samples that follow."""
        if not self._low.shape[1]:
            self._low = np.zeros((self._capacity, samples.values.shape[1]))
            self._high = self._low.copy()
            self._first_step = samples.first_step
        time, values = samples.time, samples.values
        if self._rest is not None:
            time = np.concatenate([self._rest.time, time])
            values = np.concatenate([self._rest.values, values])
        while len(time) >= self._size:
            full = min(len(time) // self._size, self._capacity - self._count)
            self._fill(time[: full * self._size], values[: full * self._size])
            time, values = time[full * self._size :], values[full * self._size :]
            if self._count == self._capacity:
                self._halve()
        self._rest = SampleSeries(samples.end - len(time), time, time, values.copy())

    def bins(self) -> Bins:
        """The bins so far."""
        time, low, high = (part[: self._count] for part in (self._time, self._low, self._high))
        if self._rest is not None and len(self._rest):
            values = self._rest.values
            time = np.append(time, self._rest.time[0])
            low = np.vstack([low, np.fmin.reduce(values, axis=0)])
            high = np.vstack([high, np.fmax.reduce(values, axis=0)])
        return Bins(self._size, self._first_step, time, low, high)

    def _fill(self, time: Real, values: Real) -> None:
        parts = values.reshape(-1, self._size, values.shape[1])
        target = slice(self._count, self._count + len(parts))
        self._time[target] = time[:: self._size]
        self._low[target], self._high[target] = np.fmin.reduce(parts, axis=1), np.fmax.reduce(parts, axis=1)
        self._count += len(parts)

    def _halve(self) -> None:
        half = self._count // 2
        self._time[:half] = self._time[::2]
        self._low[:half] = np.fmin(self._low[::2], self._low[1::2])
        self._high[:half] = np.fmax(self._high[::2], self._high[1::2])
        self._count = half
        self._size *= 2


@dataclass(frozen=True, eq=False)
class Drawn:
    """What a page draws of a run: bins, and single samples where these are known."""

    time: Real
    """(entries,), s."""
    low: Real
    """(entries, columns); equal to ``high`` for a single sample."""
    high: Real
    """(entries, columns)"""


def drawn(bins: Bins, closeups: list[SampleSeries]) -> Drawn:
    """Bins of a run with every bin that lies within a close-up resolved into its samples."""
    if bins.size == 1:
        return Drawn(bins.time, bins.low, bins.high)
    resolved: dict[int, SampleSeries] = {}
    for closeup in closeups:
        first = -(-(closeup.first_step - bins.first_step) // bins.size)
        end = (closeup.end - bins.first_step) // bins.size
        for number in range(first, end):
            start = bins.first_step + number * bins.size
            resolved.setdefault(number, closeup.between(start, start + bins.size))
    coarse = np.ones(len(bins), np.bool_)
    coarse[[*resolved]] = False
    fine = [resolved[number] for number in sorted(resolved)]
    time = np.concatenate([bins.time[coarse], *(part.time for part in fine)])
    low, high = (
        np.concatenate([part[coarse], *(samples.values for samples in fine)]) for part in (bins.low, bins.high)
    )
    order = np.argsort(time, kind="stable")
    return Drawn(time[order], low[order], high[order])
