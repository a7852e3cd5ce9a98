"""No number that is not one leaves a simulation."""

from __future__ import annotations

import numpy as np

from ..errors import DivergenceError
from ..runtime.arrays import Real


def require_finite(first_step: int, **samples: Real) -> None:
    """Raise DivergenceError if any of the samples (n, ...) from ``first_step`` on is not finite.

    It names the first step at which that is so, and that step's values of all that is given.
    """
    if all(np.isfinite(values).all() for values in samples.values()):
        return
    bad = np.any([~np.isfinite(values.reshape(len(values), -1)).all(axis=1) for values in samples.values()], axis=0)
    row = int(bad.argmax())
    told = ", ".join(
        f"{name.replace('_', ' ')} {np.array2string(values[row].ravel(), precision=6, max_line_width=10**9)}"
        for name, values in samples.items()
    )
    raise DivergenceError(f"step {first_step + row} is not finite ({told}): the models at this speed are not stable")
