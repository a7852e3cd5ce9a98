"""The active set of a contact that is nearly that of smooth surfaces, without a factorisation.

The elements are put in the order in which a contact of smooth surfaces takes them in as it grows. The Cholesky factor
L of their influence matrix K then holds the factor of every such contact as a leading block, and so does its inverse:
one factorisation, done beforehand, solves smooth contacts of any size n by two products with triangles.

The contact of rough surfaces differs from its best n by some elements: ``added`` ones beyond n, whose rows of L are
there already, and ``removed`` ones before n, held at zero pressure by fictitious displacements x. With y = L^-1 times
the overlap, the unknowns of the k differences solve a k x k system (Schur complement; quasi-definite, so elimination
needs no pivoting), whose entries are short sums over L and L^-1 near n. Nothing is carried from step to step but the
first guess: the solution of a contact problem depends on nothing else, to the last bit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...runtime.jit import block_kernel, kernel
from ..active_set_kernels import CONVERGED, RELATIVE_TOLERANCE, SIMULTANEOUS
from .difference_kernels import (
    HALF,
    MOST_DIFFERENCES,
    forget,
    no_differences,
    out_of_order,
    solve_system,
    take_in,
    triangular_system,
)
from .order_kernels import FAR, NestedContacts, bring_in_far, smooth_contact
from .panel_kernels import Vector, clear, dot, multiply, multiply_transposed, width


@block_kernel
def let_go(
    p: Vector,
    first: int,
    end: int,
    places: NDArray[np.int64],
    suction: float,
    in_contact: NDArray[np.bool_],
) -> int:
    """Take elements from ``first`` to ``end`` whose pressure ``p`` is below ``suction`` out of contact; how many.

    Those at ``places``, out of order, are not among them: theirs is set to zero.
    """
    for c in places:
        p[c] = 0.0
    changes = 0
    pressures, bear = p[first:end], in_contact[first:end]
    for c in range(len(bear)):
        if pressures[c] < suction:
            bear[c] = False
            changes += 1
    return changes


@block_kernel
def bring_in(
    felt: Vector,
    first: int,
    end: int,
    places: NDArray[np.int64],
    overlap: Vector,
    lost: float,
    in_contact: NDArray[np.bool_],
) -> int:
    """Bring elements whose displacement ``felt``, m, is less than ``overlap - lost`` into contact; returns how many.

    Those at ``places``, out of order, are not among them.
    """
    for c in places:
        felt[c] = np.inf
    changes = 0
    displaced, over, bear = felt[first:end], overlap[first:end], in_contact[first:end]
    for c in range(len(bear)):
        if displaced[c] < over[c] - lost:
            bear[c] = True
            changes += 1
    return changes


@kernel
def solve_in_order(
    nested: NestedContacts,
    gap: Vector,
    element_area: float,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Vector,
) -> tuple[float, float, int]:
    """Contact force, N, its derivative by the approach, N/m, and a status, as ``solve_active_set``.

    All by order: ``gap`` (m,), m, of the elements that can be in contact, ``in_contact`` (m,) with the first guess,
    left with the solution, ``pressure`` (m,), Pa, filled. With a status of FAR this is no contact for this method, and
    ``in_contact`` is left with anything.
    """
    m = len(gap)
    deepest, edge, n = smooth_contact(nested, gap, approach, compliance, element_area)
    if deepest >= approach:
        for c in range(m):
            in_contact[c] = False
            pressure[c] = 0.0
        return 0.0, 0.0, CONVERGED
    if n > len(nested.punch):
        return np.nan, np.nan, FAR
    # How far this is from a smooth contact is judged by the gap alone, lest the result depend on the guess.
    apart, guessed = 0, 0
    for c in range(m):
        apart += (gap[c] < edge) != (c < n)
        guessed += in_contact[c]
    if apart > MOST_DIFFERENCES:
        return np.nan, np.nan, FAR

    # Columns beyond which products are zero, by whole 32: so that these have the same bits between wider ones.
    widest = n + ((m - n + 31) & -32)
    low, high = max(n - n // 4, 0) & -32, min(n + ((n // 4 + 31) & -32), widest)
    vectors = np.empty((6, widest))
    overlap, y, v, p, w, felt = vectors[0], vectors[1, :n], vectors[2, :n], vectors[3], vectors[4], vectors[5]
    for c in range(m):
        overlap[c] = approach - gap[c]
    multiply(nested.inverse, 0, n, overlap, y)
    punch = nested.punch[:n]
    smooth_load, smooth_punch = dot(punch, y), dot(punch, punch)
    tolerance = RELATIVE_TOLERANCE * (approach - deepest)
    suction = -tolerance / nested.own

    d = no_differences(m, widest)
    forget(d)
    Q, pivot, x = np.empty((HALF, width(HALF + 1))), np.empty(HALF), np.empty(width(HALF + 1))
    listed, marks = np.empty(MOST_DIFFERENCES + 1, np.int64), np.zeros(width(m), np.uint8)
    # Elements change near the edge: only where nothing changes there, all others are looked at.
    near, end = low, min(n + n // 4, m)
    poor, smooth_tried = guessed == 0, False
    for _ in range(2 * SIMULTANEOUS):
        if poor:
            if smooth_tried:
                return np.nan, np.nan, FAR
            smooth_tried = True
            forget(d)
            for c in range(m):
                in_contact[c] = gap[c] < edge
        k = out_of_order(in_contact, n, marks, listed)
        places = listed[:k]
        if k > 0 and (places[0] < low or places[k - 1] >= high):
            low, high = 0, widest
            forget(d)
        poor = k > MOST_DIFFERENCES or not take_in(
            nested.factor, nested.inverse, nested.punch, d, places, low, high, y, overlap
        )
        if poor:
            continue

        load, relief = triangular_system(d, places, Q, pivot)
        stiffness = element_area * (smooth_punch + relief)
        force = element_area * (smooth_load + load) / (1.0 + compliance * stiffness)
        stiffness /= 1.0 + compliance * stiffness
        lost = compliance * force
        local = approach - lost
        # w = L^T p of all pressures; v that of the first n without what the added ones do to them.
        for t in range(n):
            w[t] = y[t] - lost * punch[t]
        clear(w[n:])
        solve_system(nested.factor, d, places, Q, pivot, lost, x, low, v, w)

        changes = 0
        for a in range(k):
            c = places[a]
            if x[a] < (-tolerance if c < n else suction):
                in_contact[c] = c < n
                changes += 1
        multiply_transposed(nested.inverse, n, v, near, n, p)
        changes += let_go(p, near, n, places, suction, in_contact)
        multiply(nested.factor, n, end, w, felt)
        changes += bring_in(felt, n, end, places, overlap, lost + tolerance, in_contact)
        if changes == 0:
            multiply_transposed(nested.inverse, n, v, 0, near, p)
            changes += let_go(p, 0, near, places, suction, in_contact)
            for c in range(m):
                pressure[c] = p[c] if c < n else 0.0
            for a in range(k):
                if places[a] >= n:
                    pressure[places[a]] = x[a]
            changes += bring_in_far(nested, pressure, w, gap, local, end, tolerance, in_contact)
        if changes == 0:
            return force, stiffness, CONVERGED if np.isfinite(force) else FAR
    return np.nan, np.nan, FAR
