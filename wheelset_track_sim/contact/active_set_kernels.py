"""Kalker's variational method for the normal contact: the active set, Eqs (8) to (12).

The unknowns are the pressures of the elements in contact. With half-spaces the surfaces only move apart where they
are not in contact, so every element in contact has an undeformed separation below the approach: these candidates are
all that is looked at. Where separation is symmetric about y = 0, half of the elements stand for all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import kernel

CONVERGED = 0
NOT_CONVERGED = 1
AT_BORDER = 2
NOT_FINITE = 3

SIMULTANEOUS = 20
MOST_ITERATIONS = 200
RELATIVE_TOLERANCE = 1e-11


@kernel
def pair(influence: Real, mirrored: bool, centre: int, i: int, j: int, I: int, J: int) -> float:  # noqa: E741
    """Influence of unit pressure on element (I, J) at (i, j), m/Pa; with ``mirrored`` the mean with its image."""
    direct: float = influence[abs(i - I), abs(j - J)]
    if mirrored:
        image: float = influence[abs(i - I), j + J - 2 * centre]
        return 0.5 * (direct + image)
    return direct


@kernel
def at_border(nx: int, ny: int, mirrored: bool, i: int, j: int) -> bool:
    """Whether element (i, j) lies at the border of the potential contact area."""
    return i == 0 or i == nx - 1 or j == ny - 1 or (j == 0 and not mirrored)


@kernel
def cholesky(K: Real) -> bool:
    """Factor K = U^T U in place, upper triangle; False if K is not positive definite.

    Four rows at a time, so that each sweep over the rest does four updates for one load and store.
    """
    n = len(K)
    for k in range(0, n, 4):
        last = min(k + 4, n)
        for row in range(k, last):
            target = K[row, row:]
            for done in range(k, row):
                factor = K[done, row]
                source = K[done, row:]
                for j in range(len(target)):
                    target[j] -= factor * source[j]
            if not target[0] > 0.0:
                return False
            scale = 1.0 / np.sqrt(target[0])
            for j in range(len(target)):
                target[j] *= scale
        for i in range(last, n):
            f0, f1, f2, f3 = K[k, i], K[k + 1, i], K[k + 2, i], K[k + 3, i]
            r0, r1, r2, r3 = K[k, i:], K[k + 1, i:], K[k + 2, i:], K[k + 3, i:]
            target = K[i, i:]
            for j in range(len(target)):
                target[j] -= f0 * r0[j] + f1 * r1[j] + f2 * r2[j] + f3 * r3[j]
    return True


@kernel
def forward(U: Real, b: Real) -> None:
    """Solve U^T y = b in place."""
    for k in range(len(b)):
        b[k] /= U[k, k]
        row = U[k, k + 1 :]
        rest = b[k + 1 :]
        for j in range(len(rest)):
            rest[j] -= b[k] * row[j]


@kernel
def backward(U: Real, y: Real) -> None:
    """Solve U x = y in place."""
    n = len(y)
    for k in range(n - 1, -1, -1):
        even, odd = 0.0, 0.0
        for j in range(k + 1, n - 1, 2):
            even += U[k, j] * y[j]
            odd += U[k, j + 1] * y[j + 1]
        if (n - k) % 2 == 0:
            even += U[k, n - 1] * y[n - 1]
        y[k] = (y[k] - even - odd) / U[k, k]


@kernel
def candidates(separation: Real, mirrored: bool, approach: float) -> tuple[NDArray[np.int64], NDArray[np.int64], Real]:
    """Elements that can be in contact, ordered by position: indices i and j, and separation, m."""
    nx, ny = separation.shape
    first = ny // 2 if mirrored else 0
    count = 0
    for i in range(nx):
        for j in range(first, ny):
            count += separation[i, j] < approach
    at_i, at_j, gap = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count)
    count = 0
    for i in range(nx):
        for j in range(first, ny):
            if separation[i, j] < approach:
                at_i[count], at_j[count], gap[count] = i, j, separation[i, j]
                count += 1
    return at_i, at_j, gap


@kernel
def solve_active_set(
    separation: Real,
    mirrored: bool,
    influence: Real,
    element_area: float,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Contact force, N, its derivative by the approach, N/m, and a status; no contact is zero force and stiffness.

    ``separation`` (nx, ny), m, undeformed, irregularities included; with ``mirrored`` it is symmetric about the middle
    column. ``compliance`` c0, m/N, is further instantaneous compliance: the approach at the contact is approach - c0 F.
    ``in_contact`` (nx, ny) is the first guess, left with the solution; of it, only the path to the solution depends,
    for the last factorisation has its elements in the order of their positions. ``pressure`` is filled, Pa, if it is
    of the area's shape; pass an empty (0, 0) array if only the force is of interest.
    Force and stiffness are NaN unless the status is CONVERGED.
    """
    nx, ny = separation.shape
    if not np.isfinite(approach) or not compliance >= 0.0:
        return np.nan, np.nan, NOT_FINITE
    at_i, at_j, gap = candidates(separation, mirrored, approach)
    m = len(gap)
    if pressure.size:
        pressure[:] = 0.0
    if m == 0:
        in_contact[:] = False
        return 0.0, 0.0, CONVERGED
    centre = ny // 2
    weight = np.ones(m)
    lowest = gap[0]
    for a in range(m):  # loops: masks and reductions of NumPy take seconds to compile
        lowest = min(lowest, gap[a])
        if mirrored and at_j[a] != centre:
            weight[a] = 2.0
    active = np.empty(m, np.bool_)
    occupied = False
    # Hertz: the edge of the contact lies where the undeformed separation is half the approach.
    edge = 0.5 * (lowest + approach)
    for a in range(m):
        active[a] = in_contact[at_i[a], at_j[a]]
        occupied |= active[a]
        if gap[a] <= edge and at_border(nx, ny, mirrored, at_i[a], at_j[a]):
            # Far too deep for the area: no need to solve for thousands of elements to find out.
            in_contact[:] = False
            return np.nan, np.nan, AT_BORDER
    if not occupied:
        for a in range(m):
            active[a] = gap[a] <= edge
    tolerance = RELATIVE_TOLERANCE * (approach - lowest)
    force, stiffness, status = np.nan, np.nan, NOT_CONVERGED
    for iteration in range(MOST_ITERATIONS):
        chosen = np.nonzero(active)[0]
        n = len(chosen)
        K = np.empty((n, n))
        load, punch = np.empty(n), np.empty(n)
        for a in range(n):
            c = chosen[a]
            punch[a] = weight[c]
            load[a] = weight[c] * (approach - gap[c])
            for b in range(a, n):
                d = chosen[b]
                K[a, b] = weight[c] * weight[d] * pair(influence, mirrored, centre, at_i[c], at_j[c], at_i[d], at_j[d])
        if not cholesky(K):
            status = NOT_FINITE
            break
        forward(K, load)
        forward(K, punch)
        force0, stiffness0 = 0.0, 0.0
        for a in range(n):
            force0 += punch[a] * load[a]
            stiffness0 += punch[a] * punch[a]
        relief = 1.0 + compliance * element_area * stiffness0
        force = element_area * force0 / relief
        stiffness = element_area * stiffness0 / relief
        for a in range(n):
            load[a] -= compliance * force * punch[a]
        backward(K, load)
        local = approach - compliance * force

        removed, added = 0, 0
        for a in range(n):
            if load[a] * influence[0, 0] < -tolerance:
                active[chosen[a]] = False
                removed += 1
        if removed == 0 or iteration < SIMULTANEOUS:
            # Elements are exchanged both ways at once, which converges in a few steps; should that ever cycle,
            # Kalker's order (first remove all that pull, then add all that overlap) takes over.
            present = np.zeros(m, np.bool_)
            for a in range(n):
                present[chosen[a]] = True
            for c in range(m):
                if present[c]:
                    continue
                distance = gap[c] - local
                for b in range(n):
                    d = chosen[b]
                    distance += (
                        weight[d] * load[b] * pair(influence, mirrored, centre, at_i[c], at_j[c], at_i[d], at_j[d])
                    )
                if distance < -tolerance:
                    active[c] = True
                    added += 1
        if removed + added == 0:
            status = CONVERGED
            break
        if not active.any():
            # All pull: only from a poor guess, since the deepest element must bear.
            active[np.argmin(gap)] = True

    in_contact[:] = False
    if status == CONVERGED and not np.isfinite(force):
        status = NOT_FINITE
    if status == CONVERGED:
        for a in range(len(chosen)):
            i, j = at_i[chosen[a]], at_j[chosen[a]]
            in_contact[i, j] = True
            if at_border(nx, ny, mirrored, i, j):
                status = AT_BORDER
            if mirrored:
                in_contact[i, 2 * centre - j] = True
            if pressure.size:
                pressure[i, j] = max(load[a], 0.0)
                if mirrored:
                    pressure[i, 2 * centre - j] = pressure[i, j]
    if status != CONVERGED:
        in_contact[:] = False
        return np.nan, np.nan, status
    return force, stiffness, status
