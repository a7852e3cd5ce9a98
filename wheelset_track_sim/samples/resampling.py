"""Signals on another axis without aliasing: a windowed sinc wherever the new samples stand.

A new sample is the weighted mean of the old ones around it, by the low pass of ``decimation``: flat to 80 %
of half the lower of both sampling rates, 80 dB down from there on. New samples may stand between the old ones, so that
one filter resamples, shifts by parts of a step, and takes away what the slower of two systems cannot show.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.special import i0

from ..runtime.arrays import Real
from .decimation import PASSBAND, REACH

FINE = 4096
"""Points a step at which the low pass is tabulated: the error is 1e-7."""
AT_ONCE = 1 << 22
"""Weights that are worked out at a time."""
BETA = 0.1102 * (7.95 + 2.285 * 2 * REACH * (1.0 - PASSBAND) * math.pi - 8.7)
"""Of the Kaiser window, as in ``low_pass``."""


def band_limited(signals: Real, places: Real, band_step: float = 1.0) -> Real:
    """Signals (n, signals), one a step, at ``places`` (m,) in steps from the first one: (m, signals).

    ``band_step`` is the step, in old ones and not below 1, whose half sampling rate bounds the band. Before the first
    and behind the last sample signals are taken to stay as they are.
    """
    width = max(1.0, band_step)
    half = math.ceil(REACH * width)
    taps = np.arange(-half, half + 2)
    padded = _padded(signals, half)
    out = np.empty((len(places), signals.shape[1]))
    rows = max(1, AT_ONCE // len(taps))
    for first in range(0, len(places), rows):
        part = np.clip(places[first : first + rows], 0.0, len(signals) - 1.0)
        base = np.floor(part).astype(np.intp)
        weights = _weights((taps - (part - base)[:, np.newaxis]) / width)
        for column in range(signals.shape[1]):
            around = sliding_window_view(padded[:, column], len(taps))[base]
            out[first : first + rows, column] = np.einsum("ij,ij->i", weights, around)
    return out


def shifted(signals: Real, start: int, end: int, steps: float) -> Real:
    """``band_limited`` at the places from ``start`` to before ``end``, less ``steps``: (end - start, signals).

    All of them lie between the first sample and the last.
    """
    whole = math.floor(-steps)
    taps = np.arange(-REACH, REACH + 2, dtype=np.float64)
    weights = _weights((taps - (-steps - whole))[np.newaxis])[0]
    part = _padded(signals, REACH)[start + whole : end + whole + len(weights) - 1]
    return np.stack([np.convolve(column, weights[::-1], "valid") for column in part.T], axis=-1)


def _padded(signals: Real, half: int) -> Real:
    return np.concatenate([np.repeat(signals[:1], half, 0), signals, np.repeat(signals[-1:], half + 1, 0)])


def _weights(offsets: Real) -> Real:
    """Of samples at ``offsets`` (m, taps) from the new ones, in steps of the band; the sum of each row is 1."""
    response = response_table()
    distance = _distances()
    weights = np.interp(np.abs(offsets), distance, response)
    weights /= weights.sum(axis=1, keepdims=True)
    return weights


@cache
def _distances() -> Real:
    return np.append(np.linspace(0.0, REACH, FINE * REACH + 1), REACH + 1e-9)


@cache
def response_table() -> Real:
    """The low pass at ``FINE`` points a step from its middle to ``REACH``, and 0: it can be read off linearly."""
    distance = np.linspace(0.0, REACH, FINE * REACH + 1)
    window = i0(BETA * np.sqrt(1.0 - (distance / REACH) ** 2))
    return np.append(window * np.sinc((1.0 + PASSBAND) / 2 * distance), 0.0)
