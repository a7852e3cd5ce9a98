"""The sums of the decimation filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..jit import kernel


@kernel
def accumulate(
    sums: NDArray[np.float64],
    first_output: int,
    first_step: int,
    weights: NDArray[np.float64],
    samples: NDArray[np.float64],
) -> None:
    """Add the ``samples`` (n, signals) of consecutive steps to the outputs ``sums`` (signals, outputs) they belong to.

    The step ``number * factor + phase`` is part of output ``number - reach + i`` with ``weights[phase, i]``, shape
    (factor, 2 reach + 1). Each output adds up step by step, so that its bits do not depend on how a run is cut.
    """
    factor, span = weights.shape
    for row in range(len(samples)):
        number = (first_step + row) // factor
        phase = first_step + row - number * factor
        place = number - span // 2 - first_output
        low = max(-place, 0 if phase == 0 else 1)  # what is complete, or before the first output, stays as it is
        response = weights[phase, low:]
        for signal in range(samples.shape[1]):
            value = samples[row, signal]
            target = sums[signal, place + low : place + span]
            for i in range(len(target)):
                target[i] += response[i] * value
