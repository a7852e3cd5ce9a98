"""Noise of sensors by the number of the sample: the same for the same seed, wherever a run is cut or begins."""

from __future__ import annotations

import hashlib
import math

import numpy as np

from ..runtime.arrays import Real

PAGE = 4096
"""Numbers that are drawn together."""


class Numbers:
    """Normally distributed numbers of unit variance, one for each sample, for a few channels."""

    def __init__(self, key: str, channels: int) -> None:
        """``key`` tells streams apart."""
        self._key = int.from_bytes(hashlib.blake2b(key.encode(), digest_size=16).digest(), "little")
        self._channels = channels
        self._number = -1
        self._page = np.zeros((0, channels))

    def between(self, first: int, end: int) -> Real:
        """Those of the samples ``first`` to ``end - 1``: (samples, channels)."""
        pages = range(first // PAGE, -(-end // PAGE))
        parts = [self._drawn(page)[max(0, first - page * PAGE) : end - page * PAGE] for page in pages]
        return np.concatenate([np.zeros((0, self._channels)), *parts])

    def _drawn(self, page: int) -> Real:
        if page != self._number:
            bits = np.random.Philox(key=self._key, counter=[0, 0, 0, page])
            self._number, self._page = page, np.random.Generator(bits).standard_normal((PAGE, self._channels))
        return self._page


class Walk:
    """A random walk: the sum of such numbers from sample 0 on."""

    def __init__(self, key: str, channels: int) -> None:
        """As of ``Numbers``."""
        self._numbers = Numbers(key, channels)
        self._next, self._sum = 0, np.zeros((1, channels))

    def between(self, first: int, end: int) -> Real:
        """The walk at the samples ``first`` to ``end - 1``, which do not come before those asked for earlier."""
        while self._next < first:
            skipped = min(first, (self._next // PAGE + 1) * PAGE)
            self._advance(skipped)
        return self._advance(end)

    def _advance(self, end: int) -> Real:
        steps = np.concatenate([self._sum, self._numbers.between(self._next, end)])
        walked: Real = np.cumsum(steps, axis=0)[1:]  # one by one, so that no cut changes a bit
        if len(walked):
            self._next, self._sum = end, walked[-1:]
        return walked


class Noise:
    """White noise and drift of a sensor."""

    def __init__(self, key: str, channels: int, rate: float) -> None:
        """For samples at ``rate`` Hz; ``key`` tells streams apart."""
        self._white, self._walk = Numbers(f"white {key}", channels), Walk(f"drift {key}", channels)
        self._root = math.sqrt(rate)

    def added(self, first: int, signals: Real, noise: Real, drift: Real) -> Real:
        """Signals (samples, channels), from the sample ``first`` on, with noise.

        ``noise`` (samples,) is the standard deviation of the white noise of each sample. ``drift`` (samples,) is that
        of the drift after a second: a random walk since sample 0, by its present size.
        """
        end = first + len(signals)
        for size, numbers in ((noise, self._white), (drift / self._root, self._walk)):
            if size.any():
                each = size[:, np.newaxis]
                signals = np.where(each > 0.0, signals + each * numbers.between(first, end), signals)
        return signals
