"""The sums of the decimation filter: output k is sum_n h[n - k M] x_n, with the factor M, added up as x_n arrives."""

from __future__ import annotations

from ..runtime.arrays import Real
from ..runtime.jit import kernel


@kernel
def accumulate(
    sums: Real,
    first_output: int,
    first_step: int,
    weights: Real,
    samples: Real,
) -> None:
    """Add the samples of consecutive steps to the outputs that they are part of.

    Each output adds up step by step, so its bits do not depend on how a run is cut into blocks.

    Parameters
    ----------
    sums
        Outputs, (signals, outputs); changed in place.
    first_output
        Number of the first of these outputs.
    first_step
        Step of the first sample.
    weights
        Filter, (factor, 2 reach + 1). The step ``number * factor + phase`` is part of output ``number - reach + i``
        with ``weights[phase, i]``.
    samples
        (signals, n).
    """
    factor, span = weights.shape
    row, rows = 0, samples.shape[1]
    while row < rows:
        number = (first_step + row) // factor
        phase = first_step + row - number * factor
        place = number - span // 2 - first_output
        low = max(-place, 0 if phase == 0 else 1)  # outputs that are complete, or before the first, stay as they are
        four = phase + 4 <= factor and row + 4 <= rows  # at a time, which spares most of the loads and stores
        for signal in range(len(samples)):
            target = sums[signal, place + low : place + span]
            if four:
                w_0, w_1 = weights[phase, low:], weights[phase + 1, low:]
                w_2, w_3 = weights[phase + 2, low:], weights[phase + 3, low:]
                x_0, x_1 = samples[signal, row], samples[signal, row + 1]
                x_2, x_3 = samples[signal, row + 2], samples[signal, row + 3]
                if x_0 == 0.0 and x_1 == 0.0 and x_2 == 0.0 and x_3 == 0.0:  # stresses that are zero by symmetry
                    continue
                for i in range(len(target)):
                    target[i] = (((target[i] + w_0[i] * x_0) + w_1[i] * x_1) + w_2[i] * x_2) + w_3[i] * x_3
            else:
                w, x = weights[phase, low:], samples[signal, row]
                for i in range(len(target)):
                    target[i] += w[i] * x
        row += 4 if four else 1
