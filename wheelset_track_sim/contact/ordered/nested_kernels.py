"""The active set of a contact that is nearly smooth, without a factorisation in the step.

Problem. ``active_set_kernels`` states it and has the symbols; w = 1 here. Solve it for surfaces whose roughness
changes the set of elements in contact by some tens.

Smooth contact. The M elements are numbered in the order in which a contact of smooth surfaces takes them in as it grows
(``nested.nested_contacts``). A = L L^T in that order is factored once. For any n the leading block L_n of L, n rows and
columns, is the factor for the first n elements, and the leading block of L^-1 is L_n^-1. With o = delta - g
(``overlap``)::

    y = L_n^-1 o,   h = L_n^-1 1,   p = L_n^-T (y - c0 F h),   F = s h.y / (1 + c0 s h.h).

Rough contact. Its set is the first n elements without some removed ones R, and with some added ones T from place n on.
The unknowns x_R are the distances of R, where the pressure is zero; x_T are the pressures of T. E has the columns R of
the unit matrix, and A_nT the columns T of the first n rows of A::

    A_nn p + A_nT x_T - E x_R = o_n - c0 F       d = 0 on the first n but for R
    E^T p                     = 0                no pressure on R
    A_Tn p + A_TT x_T         = o_T - c0 F       d = 0 on T

Let v = L_n^T p, C = L_n^-1 E (columns of L^-1), and B and D the rows T of L before and from column n on. Then
A_Tn = B L_n^T and A_TT = B B^T + D D^T. The first equation gives v, and the others become the system of k = |R| + |T|
equations that ``difference_kernels`` solves::

    v = y - c0 F h + C x_R - B^T x_T

    [ -C^T C   (B C)^T ] [ x_R ]   [ C^T y    ]          [ C^T h   ]
    [  B C      D D^T  ] [ x_T ] = [ o_T - B y ] - c0 F  [ 1 - B h ]      Q x = l - c0 F r

The sum of all pressures is h.v + 1.x_T = h.y + r.Q^-1 l - c0 F (h.h + r.Q^-1 r). It gives force and stiffness as in
``active_set_kernels``, with h.y + r.Q^-1 l in place of h.y and h.h + r.Q^-1 r in place of h.h.

Conditions. Let w = L^T p over all pressures: v + B^T x_T = y - c0 F h + C x_R on the first n columns, D^T x_T beyond.
Row c of L times w is the displacement of element c. Elements are exchanged as in ``active_set_kernels``, at first only
those within n / 4 places of n, where sets change. When none of them changes, all others are looked at as well.

Termination. The search ends after 2 SIMULTANEOUS trials at the latest. It then gives up with the status FAR, as it does
with more than MOST_DIFFERENCES elements out of order, or n beyond half of M; the plain active set takes over
(``law_kernels.solve_contact``).

Repeatability. The last trial depends on the problem and its set only, so the first guess does not change a bit of the
solution. There is one exception. If the final set has at most MOST_DIFFERENCES elements out of order but a set on the
way has more, one guess can end in FAR and another one not. The two answers then differ by rounding, 1e-11. This
happens in one of a thousand contacts with roughness 12 dB above the default spectrum, and was not found up to 8 dB.

Cost: n^2 / 2 multiply-adds each for y and for all pressures. Each trial takes some n^2 / 3 for the elements near the
edge, and k^3 / 6 and products of length n / 4 for the differences. The force is that of ``solve_active_set`` to 1e-11.

Source: derived here; Schur complements of a Cholesky factor.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...runtime.jit import block_kernel, inner_kernel, kernel
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
    """Take elements that pull out of contact, and return how many.

    Parameters
    ----------
    p
        Pressures by place, Pa; set to zero at ``places``.
    first, end
        Places that are looked at.
    places
        Elements out of order, which are left as they are.
    suction
        Pressure below which an element leaves, Pa.
    in_contact
        By place; changed in place.
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
    """Bring elements that overlap into contact, and return how many.

    Parameters
    ----------
    felt
        Displacements by place, m; set to infinity at ``places``.
    first, end
        Places that are looked at.
    places
        Elements out of order, which are left as they are.
    overlap, lost
        An element enters if it is displaced by less than ``overlap - lost``, m.
    in_contact
        By place; changed in place.
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


@inner_kernel
def nearly_smooth(gap: Vector, edge: float, n: int) -> bool:
    """Whether at most MOST_DIFFERENCES elements are below ``edge``, m, from place n on, or above it before place n.

    The gap alone decides that. If the first guess did, the method would depend on it.
    """
    apart = 0
    for c in range(len(gap)):
        apart += (gap[c] < edge) != (c < n)
    return apart <= MOST_DIFFERENCES


@inner_kernel
def exchange_in_order(
    nested: NestedContacts,
    gap: Vector,
    overlap: Vector,
    places: NDArray[np.int64],
    x: Vector,
    v: Vector,
    w: Vector,
    near: int,
    end: int,
    lost: float,
    local: float,
    tolerance: float,
    p: Vector,
    felt: Vector,
    in_contact: NDArray[np.bool_],
    pressure: Vector,
) -> int:
    """Exchange elements that break Eq. (8), and return how many. If none does, ``pressure`` is filled.

    Parameters
    ----------
    nested
        Elements in their order.
    gap, overlap
        g and delta - g, (m,), m.
    places, x
        Elements out of order, (k,), and their unknowns: distances of removed ones, m, pressures of added ones, Pa.
    v, w
        L_n^T p of the first n elements, (n,), and L^T p of all pressures, (m,) or longer, sqrt(m Pa).
    near, end
        Places before and after n that are looked at first.
    lost, local
        c0 F and delta - c0 F, m.
    tolerance
        Overlap that counts as none, m; suction counts as none down to ``tolerance / nested.own``.
    p, felt
        Scratch for pressures, Pa, and displacements, m, (m,) or longer.
    in_contact, pressure
        As in ``solve_in_order``.
    """
    n, changes, suction = len(v), 0, -tolerance / nested.own
    for a in range(len(places)):
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
        for c in range(len(pressure)):
            pressure[c] = p[c] if c < n else 0.0
        for a in range(len(places)):
            if places[a] >= n:
                pressure[places[a]] = x[a]
        changes += bring_in_far(nested, pressure, w, gap, local, end, tolerance, in_contact)
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
    """Solve the contact of one geometry at one approach, if it is nearly smooth.

    Parameters
    ----------
    nested
        Elements in their order.
    gap
        Separations g of the candidates by place, (m,), m.
    element_area, approach, compliance
        s, m^2, delta, m, and c0, m/N.
    in_contact
        First guess by place, (m,); left with the solution.
    pressure
        Filled with the pressures by place, (m,), Pa.

    Returns
    -------
    force, stiffness
        F, N, and dF/d delta, N/m; 0 without contact, NaN with a status of FAR.
    status
        CONVERGED, or FAR for a contact that is not for this method. ``in_contact`` and ``pressure`` then hold nothing
        of use.
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
    if not nearly_smooth(gap, edge, n):
        return np.nan, np.nan, FAR
    guessed = 0
    for c in range(m):
        guessed += in_contact[c]

    # Columns beyond which products are zero, in multiples of 32: wider sums then have the same bits.
    widest = n + ((m - n + 31) & -32)
    low, high = max(n - n // 4, 0) & -32, min(n + ((n // 4 + 31) & -32), widest)
    vectors = np.empty((6, widest))
    overlap, y, v, p, w, felt = vectors[0], vectors[1, :n], vectors[2, :n], vectors[3], vectors[4], vectors[5]
    for c in range(m):
        overlap[c] = approach - gap[c]
    multiply(nested.inverse, 0, n, overlap, y)
    punch = nested.punch[:n]
    smooth_load, smooth_punch = dot(punch, y), dot(punch, punch)

    d = no_differences(m, widest)
    forget(d)
    Q, pivot, x = np.empty((HALF, width(HALF + 1))), np.empty(HALF), np.empty(width(HALF + 1))
    listed, marks = np.empty(MOST_DIFFERENCES + 1, np.int64), np.zeros(width(m), np.uint8)
    tolerance = RELATIVE_TOLERANCE * (approach - deepest)
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
        for t in range(n):
            w[t] = y[t] - lost * punch[t]
        clear(w[n:])
        solve_system(nested.factor, d, places, Q, pivot, lost, x, low, v, w)

        changes = exchange_in_order(
            nested, gap, overlap, places, x, v, w, near, end, lost, local, tolerance, p, felt, in_contact, pressure
        )
        if changes == 0:
            return force, stiffness, CONVERGED if np.isfinite(force) else FAR
    return np.nan, np.nan, FAR
