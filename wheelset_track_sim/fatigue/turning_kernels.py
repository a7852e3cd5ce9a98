"""Stress of material points of a turning axle, from the bending stress in axes that do not turn, and its count.

A point that is at the angle a = theta + phi from the top sees bending in the vertical plane, b, in the horizontal
plane, h, and the mean m that is the same all around::

    sigma(t) = m + b(t) cos(theta(t) + phi) + h sin(theta(t) + phi)
"""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import Real
from ..runtime.jit import kernel
from .rainflow_kernels import Channels, count


@kernel
def count_turning(
    state: Channels,
    bending: Real,
    sideways: Real,
    mean: Real,
    cosines: Real,
    sines: Real,
    lowest: Real,
    highest: Real,
    gate: float,
    sensitivity: float,
    rules: Real,
) -> None:
    """Count the stress of K points around each of N nodes over further samples of one turn.

    Parameters
    ----------
    state
        Of N K channels, the points of the first node first; changed in place.
    bending
        b at each node, (N, n), Pa.
    sideways, mean
        h and m of each node, (N,), Pa.
    cosines, sines
        Of the angle a of each point at each sample, (K, n).
    lowest, highest
        Extremes of each point in this turn so far, (N, K), Pa; changed in place.
    gate, sensitivity, rules
        As for ``count``.
    """
    points = len(cosines)
    stress = np.empty(bending.shape[1])
    for node in range(len(bending)):
        for point in range(points):
            low, high = lowest[node, point], highest[node, point]
            for row in range(len(stress)):
                seen = mean[node] + (bending[node, row] * cosines[point, row] + sideways[node] * sines[point, row])
                stress[row] = seen
                low, high = min(low, seen), max(high, seen)
            lowest[node, point], highest[node, point] = low, high
            count(state, node * points + point, stress, gate, sensitivity, rules)
