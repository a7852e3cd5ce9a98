"""What points of a turning axle go through, sigma_k(t) = b(t) cos(theta(t) + phi_k): of each the range."""

from __future__ import annotations

from ..runtime.arrays import Real
from ..runtime.jit import kernel


@kernel
def widen(low: Real, high: Real, bending: Real, cosines: Real) -> None:
    """Widen the range of stress that each point has gone through by that of further samples.

    Parameters
    ----------
    low, high
        Smallest and largest stress so far, (nodes, points), Pa; changed in place.
    bending
        Bending stress at the top of the axle, (n, nodes), Pa.
    cosines
        cos(theta + phi) of each sample and point, (n, points).
    """
    for node in range(low.shape[0]):
        smallest, largest = low[node], high[node]
        for row in range(bending.shape[0]):
            stress, at = bending[row, node], cosines[row]
            for point in range(at.shape[0]):
                seen = stress * at[point]
                smallest[point] = min(smallest[point], seen)
                largest[point] = max(largest[point], seen)
