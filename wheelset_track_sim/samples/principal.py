"""Principal stresses of a symmetric stress tensor given by its six components (xx, yy, zz, xy, xz, yz)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..runtime.arrays import Real
from .principal_kernels import largest_principal_stress, principal_stresses


def principal(stress: ArrayLike) -> Real:
    """Principal stresses, largest first, (..., 3), of stress components (..., 6), in the unit given."""
    array = np.asarray(stress, dtype=np.float64)
    rows = np.ascontiguousarray(array.reshape(-1, 6))
    found = np.empty((len(rows), 3))
    principal_stresses(rows, found)
    return found.reshape(*array.shape[:-1], 3)


def maximum_principal(stress: ArrayLike) -> Real:
    """Maximum principal stress, (...), of stress components (..., 6), in the unit given.

    Fastest where the components lie in memory one after the other, each with all samples of the first axis.
    """
    array = np.asarray(stress, dtype=np.float64)
    samples = np.moveaxis(array, 0, -1) if array.ndim > 1 else array[:, np.newaxis]
    *points, six, count = samples.shape
    found = np.empty((math.prod(points), count))
    largest_principal_stress(np.ascontiguousarray(samples).reshape(len(found), six, count), found)
    return found.reshape(()) if array.ndim == 1 else np.moveaxis(found.reshape(*points, count), -1, 0)
