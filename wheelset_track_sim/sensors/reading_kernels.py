"""Samples of a sensor at its own times: a windowed sinc over the steps around each of them."""

from __future__ import annotations

import numpy as np

from ..runtime.jit import kernel


@kernel
def weigh(
    times: np.ndarray,
    periods: np.ndarray,
    signals: np.ndarray,
    centres: np.ndarray,
    first: np.ndarray,
    end: np.ndarray,
    rate: float,
    response: np.ndarray,
    fine: float,
    out: np.ndarray,
) -> None:
    """Fill ``out`` (K, C) with the weighted means of ``signals`` (n, C) around the times ``centres`` (K,), s.

    A step at ``times`` (n,) counts with its length ``periods`` (n,) and with the ``response`` of the low pass at its
    distance in samples of the sensor, tabulated at ``fine`` points a sample. ``first`` and ``end`` (K,) bound the steps
    around each centre. The order of the sums is fixed, so a sample has the same bits however a run is cut.
    """
    for k in range(centres.size):
        total = 0.0
        out[k] = 0.0
        for i in range(first[k], end[k]):
            at = abs(times[i] - centres[k]) * rate * fine
            low = int(at)
            part = at - low
            weight = periods[i] * (response[low] + part * (response[low + 1] - response[low]))
            total += weight
            for c in range(signals.shape[1]):
                out[k, c] += weight * signals[i, c]
        out[k] /= total
