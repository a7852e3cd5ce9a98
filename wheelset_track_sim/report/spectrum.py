"""Power spectral densities of a run, by Welch's method, while it passes by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..runtime.arrays import Real

SEGMENT = 2**14
"""Samples of a segment: 0.6 s at 100 km/h and 1 mm, so that the turns of the wheel (10 Hz) are resolved."""
LEAST = 2**8
"""Fewest samples that a spectrum is made of."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided power spectral densities at one speed, from segments that overlap by half under a Hann window."""

    speed: float
    """m/s"""
    segments: int
    frequency: Real
    """(frequencies,), Hz, from 0 to half the sampling rate."""
    density: Real
    """(frequencies, columns), unit of the column squared per Hz."""


class Welch:
    """Collects a run; a segment lies within a stretch at one speed, for with the speed the sampling rate changes."""

    def __init__(self, segment: int = SEGMENT) -> None:
        self._segment = segment
        self._sums: dict[float, tuple[int, float, Real]] = {}
        self._longest: tuple[float, float, Real] | None = None
        self._at: tuple[float, float] = (0.0, 0.0)
        self._rest = np.zeros((0, 0))

    def push(self, speed: float, step_period: float, values: Real) -> None:
        """Add the samples that follow, (samples, columns), at ``speed``, m/s, and ``step_period``, s."""
        if (speed, step_period) != self._at:
            self.leave()
            self._at, self._rest = (speed, step_period), values[:0]
        rest = np.concatenate([self._rest, values])
        start = 0
        while start + self._segment <= len(rest):
            self._add(rest[start : start + self._segment])
            start += self._segment // 2
        self._rest = rest[start:]

    def leave(self) -> None:
        """End a stretch: what is pushed next does not follow."""
        if self._longest is None or len(self._rest) > len(self._longest[2]):
            self._longest = *self._at, self._rest
        self._rest = self._rest[:0]

    def spectrum(self) -> Spectrum | None:
        """The spectrum at the speed with the most segments; of the longest stretch if there is no whole segment.

        None if that is too short.
        """
        self.leave()
        if self._sums:
            speed, (count, step_period, total) = max(self._sums.items(), key=lambda item: item[1][0])
            frequency = np.arange(self._segment // 2 + 1) / (self._segment * step_period)
            return Spectrum(speed, count, frequency, total / count)
        if self._longest is None or len(self._longest[2]) < LEAST:
            return None
        speed, step_period, values = self._longest
        return Spectrum(speed, 1, *_density(values, step_period))

    def _add(self, values: Real) -> None:
        speed, step_period = self._at
        density = _density(values, step_period)[1]
        count, _, total = self._sums.get(speed, (0, step_period, np.zeros_like(density)))
        self._sums[speed] = count + 1, step_period, total + density


def _density(values: Real, step_period: float) -> tuple[Real, Real]:
    found = scipy.signal.periodogram(values, 1 / step_period, window="hann", detrend="constant", axis=0)
    return np.asarray(found[0]), np.asarray(found[1])
