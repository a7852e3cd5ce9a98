"""Principal stresses in closed form, sample by sample."""

from __future__ import annotations

import math

import numpy as np

from ..runtime.jit import inner_kernel, kernel


@kernel
def principal_stresses(stress: np.ndarray, found: np.ndarray) -> None:
    """Fill ``found`` (n, 3), largest first, from components ``stress`` (n, 6): xx, yy, zz, xy, xz, yz."""
    for row in range(len(stress)):
        largest, middle, smallest = _roots(stress[row])
        found[row, 0] = largest
        found[row, 1] = middle
        found[row, 2] = smallest


@kernel
def largest_principal_stress(stress: np.ndarray, found: np.ndarray) -> None:
    """Fill ``found`` (m, n) from components ``stress`` (m, 6, n): xx, yy, zz, xy, xz, yz."""
    for point in range(len(stress)):
        xx, yy, zz, yz = stress[point, 0], stress[point, 1], stress[point, 2], stress[point, 5]
        xy, xz = stress[point, 3], stress[point, 4]
        in_plane = True
        for i in range(len(xy)):
            in_plane &= xy[i] == 0.0 and xz[i] == 0.0
        for i in range(len(xx)):
            if in_plane:  # the same numbers as from _roots, in vector registers
                half = 0.5 * (yy[i] - zz[i])
                found[point, i] = max(xx[i], 0.5 * (yy[i] + zz[i]) + math.sqrt(half * half + yz[i] * yz[i]))
            else:
                found[point, i] = _roots(stress[point, :, i])[0]


@inner_kernel
def _roots(stress: np.ndarray) -> tuple[float, float, float]:
    """Eigenvalues by the invariants of the deviator: mean ``m``, ``q = sqrt(J2 / 3)``, ``cos 3 phi = J3 / (2 q^3)``.

    They are ``m + 2 q cos(phi - 2 pi k / 3)``. In the plane of symmetry of a wheelset xy and xz vanish, xx is one of
    them, and the other two are those of a plane.
    """
    xx, yy, zz, xy, xz, yz = stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]
    if xy == 0.0 and xz == 0.0:
        half = 0.5 * (yy - zz)
        centre, radius = 0.5 * (yy + zz), math.sqrt(half * half + yz * yz)
        high, low = centre + radius, centre - radius
        return max(xx, high), max(min(xx, high), low), min(xx, low)
    mean = (xx + yy + zz) / 3
    dx, dy, dz = xx - mean, yy - mean, zz - mean
    q = math.sqrt((dx * dx + dy * dy + dz * dz + 2 * (xy * xy + xz * xz + yz * yz)) / 6)
    if q == 0.0:
        return mean, mean, mean
    a, b, c, d, e, f = dx / q, dy / q, dz / q, xy / q, xz / q, yz / q
    cosine = 0.5 * (a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e))
    phi = math.acos(min(max(cosine, -1.0), 1.0)) / 3
    largest = mean + 2 * q * math.cos(phi)
    smallest = mean + 2 * q * math.cos(phi + 2 * math.pi / 3)
    return largest, 3 * mean - largest - smallest, smallest
