"""Principal stresses of a symmetric stress tensor given by its six components (xx, yy, zz, xy, xz, yz)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .principal_kernels import largest_principal_stress, principal_stresses


def principal(stress: ArrayLike) -> NDArray[np.float64]:
    """Principal stresses, largest first, (..., 3), of stress components (..., 6), in the unit given."""
    rows, shape = _rows(stress)
    found = np.empty((len(rows), 3))
    principal_stresses(rows, found)
    return found.reshape(*shape, 3)


def maximum_principal(stress: ArrayLike) -> NDArray[np.float64]:
    """Maximum principal stress, (...), of stress components (..., 6), in the unit given."""
    rows, shape = _rows(stress)
    found = np.empty(len(rows))
    largest_principal_stress(rows, found)
    return found.reshape(shape)


def _rows(stress: ArrayLike) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    array = np.ascontiguousarray(stress, dtype=np.float64)
    return array.reshape(-1, 6), array.shape[:-1]
