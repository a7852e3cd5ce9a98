"""How far two records of the same event are apart on their axis, by cross-correlation.

For each lag the coefficient is that of Pearson over the samples that both have then, the mean of all signals. Its
maximum is searched for over quarters of steps first, and between them by resampling one record (``shifted``).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ...errors import InputError
from ...runtime.arrays import Real
from ...samples.resampling import band_limited, shifted

OVERLAP = 0.5
"""Share of the shorter record that both must have."""
ALIKE = 0.5
"""Coefficient below which the lag of two records is unknown."""
FINER = 4
"""Lags a step that are tried first: at whole ones a wave near the end of the band may be missed by half its length."""
DISTINCT = 0.95
"""Share of the best coefficient that another lag may come to: two that are as good as each other tell none."""


@dataclass(frozen=True)
class Lag:
    """Where the second record begins on the axis of the first one, in steps."""

    steps: float
    coefficient: float
    """Mean coefficient of correlation there, of all signals."""
    second: float
    """The best one of any other lag, outside of the peak; NaN if there is none."""
    uncertainty: float
    """Standard deviation of ``steps`` if what the records do not share is white noise in their band."""


def align(
    first: Real,
    second: Real,
    within: tuple[float, float] = (-math.inf, math.inf),
    shown: Callable[[float], str] = "{:g} steps".format,
) -> Lag:
    """Lag of ``second`` (m, signals) on ``first`` (n, signals), which have one step and are sampled in one band.

    Only lags ``within`` bounds, in steps, are looked at; ``shown`` tells people a lag. Raises InputError if the records
    have nothing in common, or if several lags are as good as each other.
    """
    finer = (band_limited(of, np.arange((len(of) - 1) * FINER + 1) / FINER) for of in (first, second))
    tried, coefficients = _coefficients(*finer)
    lags = tried / FINER
    least, most = within
    allowed = (lags >= least) & (lags <= most) & np.isfinite(coefficients)
    if not allowed.any():
        raise InputError(
            f"no lag from {shown(least)} to {shown(most)} makes the records overlap by half of the shorter one: "
            "give another lag"
        )
    coefficients = np.where(allowed, coefficients, -np.inf)
    best = int(coefficients.argmax())
    highest = float(coefficients[best])
    if highest < ALIKE:
        raise InputError(
            f"no lag fits: the correlation of the records is {highest:.2f} at most, "
            f"and {ALIKE:g} is needed: check that the channels and the run belong together"
        )
    other = _outside(coefficients, best)
    if other is not None and coefficients[other] > DISTINCT * highest:
        raise InputError(
            f"the lag is ambiguous: {shown(lags[best])} and {shown(lags[other])} give a correlation of {highest:.3f} "
            f"and {coefficients[other]:.3f}: give an approximate lag, or a record with less repetition"
        )
    steps, refined = _between(first, second, float(lags[best]))
    second_best = math.nan if other is None else float(coefficients[other])
    return Lag(steps, refined, second_best, _uncertainty(first, second, steps))


def _coefficients(first: Real, second: Real) -> tuple[NDArray[np.int64], Real]:
    """Lags in steps, and the coefficient of each; NaN where the overlap is too short."""
    n, m = len(first), len(second)
    lags = np.arange(-(m - 1), n)
    start, end = np.maximum(lags, 0), np.minimum(lags + m, n)
    count = end - start
    total = np.zeros(len(lags))
    size = scipy.fft.next_fast_len(n + m - 1)
    for one, other in zip(first.T, second.T, strict=True):
        x, y = _scaled(one), _scaled(other)
        product = np.fft.irfft(np.fft.rfft(x, size) * np.conj(np.fft.rfft(y, size)), size)[lags % size]
        (sx, sxx), (sy, syy) = _sums(x, start, end), _sums(y, start - lags, end - lags)
        spread = (sxx - sx**2 / count) * (syy - sy**2 / count)
        flat = spread <= 1e-12 * count.astype(float) ** 2
        total += np.where(flat, 0.0, (product - sx * sy / count) / np.sqrt(np.where(flat, 1.0, spread)))
    return lags, np.where(count >= OVERLAP * min(n, m), total / first.shape[1], np.nan)


def _scaled(signal: Real) -> Real:
    """Without mean, with unit variance."""
    centred = signal - signal.mean()
    scaled: Real = centred / (centred.std() or 1.0)
    return scaled


def _sums(signal: Real, start: NDArray[np.int64], end: NDArray[np.int64]) -> tuple[Real, Real]:
    """Sums of a signal and of its square from ``start`` to before ``end``."""
    once, twice = (np.concatenate([[0.0], np.cumsum(part)]) for part in (signal, signal**2))
    return once[end] - once[start], twice[end] - twice[start]


def _outside(coefficients: Real, best: int) -> int | None:
    """The best place outside of the peak at ``best``, which ends where half of its height is left."""
    low = coefficients < coefficients[best] / 2
    before, after = np.flatnonzero(low[:best]), np.flatnonzero(low[best:])
    outside = np.full(len(coefficients), -np.inf)
    if len(before):
        outside[: before[-1]] = coefficients[: before[-1]]
    if len(after):
        outside[best + after[0] :] = coefficients[best + after[0] :]
    found = int(outside.argmax())
    return found if np.isfinite(outside[found]) else None


def _overlapping(first: Real, second: Real, steps: float) -> tuple[Real, Real]:
    """Both records where both have samples, the second one moved by ``steps``: at the steps of the first."""
    start, end = max(0, math.ceil(steps)), min(len(first), math.floor(steps + len(second) - 1) + 1)
    return first[start:end], shifted(second, start, end, steps)


def _between(first: Real, second: Real, lag: float) -> tuple[float, float]:
    """The best lag near one that was tried, and its coefficient."""

    def loss(steps: float) -> float:
        ours, theirs = _overlapping(first, second, steps)
        return -float(np.mean([correlation(x, y) for x, y in zip(ours.T, theirs.T, strict=True)]))

    bounds = lag - 1 / FINER, lag + 1 / FINER
    found = scipy.optimize.minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 1e-4})
    return float(found.x), -float(found.fun)


def correlation(x: Real, y: Real) -> float:
    """Pearson's coefficient of two signals (n,); 0 if one of them does not change."""
    x, y = x - x.mean(), y - y.mean()
    size = math.sqrt(float(x @ x) * float(y @ y))
    return float(x @ y) / size if size > 0 else 0.0


def _uncertainty(first: Real, second: Real, steps: float) -> float:
    """Standard deviation of the maximum of the mean coefficient, steps.

    Noise of the share ``n`` of a signal tilts its coefficient by a slope of variance ``n S / N`` with ``S`` the mean
    square of the signal's derivative over its variance; the coefficient itself bends with ``S``.
    """
    ours, theirs = _overlapping(first, second, steps)
    bend = tilt = 0.0
    for x, y in zip(ours.T, theirs.T, strict=True):
        alike = correlation(x, y)
        if alike > 0:
            steepness = float(np.mean(np.gradient(x) ** 2) / np.var(x))
            bend += steepness
            tilt += (1 / alike**2 - 1) * steepness / len(x)
    return math.sqrt(max(tilt, 0.0)) / bend if bend > 0 else math.inf
