"""The sums of the decimation filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..jit import kernel


@kernel
def accumulate(
    sums: NDArray[np.float64], first_place: int, factor: int, response: NDArray[np.float64], rows: NDArray[np.float64]
) -> None:
    """Add the samples ``rows`` (n, signals) to the outputs ``sums`` (outputs, signals) that they are part of.

    Output i takes row j with the weight ``response[first_place + j - i factor]`` where there is one. Each output adds
    up in the order of the rows, one after the other, so that the bits do not depend on how a run is cut.
    """
    taps = len(response)
    for output in range(len(sums)):
        place = first_place - output * factor
        for row in range(max(0, -place), min(len(rows), taps - place)):
            weight = response[place + row]
            for signal in range(rows.shape[1]):
                sums[output, signal] += weight * rows[row, signal]
