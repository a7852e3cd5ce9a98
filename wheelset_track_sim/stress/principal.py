"""Principal stresses of a symmetric stress tensor given by its six components (xx, yy, zz, xy, xz, yz)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def principal(stress: NDArray[np.float64]) -> NDArray[np.float64]:
    """Principal stresses, largest first, (..., 3), of stress components (..., 6), in the unit given.

    Closed form by the invariants of the deviator: with mean ``m``, ``q = sqrt(J2 / 3)`` and
    ``cos 3 phi = J3 / (2 q**3)``, the roots are ``m + 2 q cos(phi - 2 pi k / 3)``.
    """
    xx, yy, zz, xy, xz, yz = np.moveaxis(np.asarray(stress, dtype=np.float64), -1, 0)
    mean = (xx + yy + zz) / 3
    dx, dy, dz = xx - mean, yy - mean, zz - mean
    shear = xy * xy + xz * xz + yz * yz
    q = np.sqrt((dx * dx + dy * dy + dz * dz + 2 * shear) / 6)
    j3 = dx * (dy * dz - yz * yz) - xy * (xy * dz - yz * xz) + xz * (xy * yz - dy * xz)
    cube = 2 * q**3
    cosine = np.clip(np.divide(j3, cube, out=np.ones_like(j3), where=cube > 0), -1, 1)
    phi = np.arccos(cosine) / 3
    largest = mean + 2 * q * np.cos(phi)
    smallest = mean + 2 * q * np.cos(phi + 2 * np.pi / 3)
    return np.stack([largest, 3 * mean - largest - smallest, smallest], axis=-1)


def maximum_principal(stress: NDArray[np.float64]) -> NDArray[np.float64]:
    """Maximum principal stress, (...), of stress components (..., 6), in the unit given."""
    largest: NDArray[np.float64] = principal(stress)[..., 0]
    return largest
