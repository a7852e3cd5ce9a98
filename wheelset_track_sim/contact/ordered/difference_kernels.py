"""Elements out of order, and the small system that joins them to a smooth contact.

``nested_kernels`` derives the system for the k elements out of order: R removed before place n, T added from n on. With
L = ``factor`` and L^-1 = ``inverse``, C are the columns R of L_n^-1, and B and D are the rows T of L before and from
column n on::

    [ -C^T C   (B C)^T ] [ x_R ]   [ C^T y    ]          [ C^T h   ]
    [  B C      D D^T  ] [ x_T ] = [ o_T - B y ] - c0 F  [ 1 - B h ],      o = delta - g (``overlap``)
            Q                         load                  punch

Storage. Each such element has a slot that holds its column of C or its row of L (``rows``), its products with all
other slots (``gram``) and both its right-hand sides. A slot depends on nothing but its element, so it stays filled
while the set of a step changes, and each trial works out the products of new elements only. Columns of C are zero
before row c, rows of L beyond column c. So products run from ``low`` to ``high`` only, which enclose all elements out
of order.

Elimination. Q is quasi-definite: C^T C and D D^T are positive definite, because columns of L^-1 are independent, and so
are the rows of D. Such a matrix has a factorisation into triangles with a diagonal of both signs, whatever the order
(R. J. Vanderbei, SIAM J. Optim. 5 (1995) 100-113), so elimination needs no pivots::

    Q = U^T diag(pivot) U,    U_aa = 1 / pivot_a,    U^T diag(pivot) [l', r'] = [load, punch],
    punch.Q^-1 load = sum_a l'_a r'_a pivot_a,    punch.Q^-1 punch = sum_a r'_a^2 pivot_a.

After elimination the array holds U, l' and r'. It takes k^3 / 6 multiply-adds, four equations at a time.

Source: derived here; Schur complements of a Cholesky factor.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, summing_kernel
from .panel_kernels import PANEL, Vector, add_scaled, clear, dot, dot_4, row, width

MOST_DIFFERENCES = 96
"""Most elements out of order. With more, a factorisation of all elements in contact takes no longer."""

HALF = MOST_DIFFERENCES + 4
"""Slots of each kind. Products are taken four at a time, so they run over up to three slots that are not taken yet."""


class OutOfOrder(NamedTuple):
    """Slots of elements out of order: removed ones from slot 0 on, added ones from slot HALF on."""

    taken: NDArray[np.int64]
    """Ends of the slots taken by removed and by added elements, (2,)."""
    slot: NDArray[np.int64]
    """Slot of each place in the order; -1 where there is none, (m,)."""
    rows: Real
    """Column of L^-1 of a removed element, row of L of an added one, (2 HALF, columns); filled from low to high."""
    gram: Real
    """Q by slots, on and below the diagonal, (2 HALF, 2 HALF)."""
    load: Vector
    """Right-hand side of the overlap by slot, (2 HALF,)."""
    punch: Vector
    """Right-hand side of a flat punch by slot, (2 HALF,)."""


@block_kernel
def no_differences(m: int, columns: int) -> OutOfOrder:
    """Empty slots for m candidates, with rows of a number of ``columns``; nothing is filled in."""
    return OutOfOrder(
        taken=np.zeros(2, np.int64),
        slot=np.empty(m, np.int64),
        rows=np.empty((2 * HALF, columns)),
        gram=np.empty((2 * HALF, 2 * HALF)),
        load=np.empty(2 * HALF),
        punch=np.empty(2 * HALF),
    )


@block_kernel
def forget(d: OutOfOrder) -> None:
    """Empty all slots."""
    d.taken[0], d.taken[1] = 0, HALF
    for c in range(len(d.slot)):
        d.slot[c] = -1


@block_kernel
def out_of_order(in_contact: NDArray[np.bool_], n: int, marks: NDArray[np.uint8], places: NDArray[np.int64]) -> int:
    """List the elements out of order: not in contact before place ``n``, or in contact from ``n`` on.

    Parameters
    ----------
    in_contact
        By place, (m,).
    n
        Elements of the smooth contact.
    marks
        Scratch, at least (m,) and a multiple of 8 long, with zeros from m on. Eight marks are looked at at a time.
    places
        Filled with the places, rising, (MOST_DIFFERENCES + 1,).

    Returns
    -------
    k
        Their number, at most MOST_DIFFERENCES + 1.
    """
    for c in range(len(in_contact)):
        marks[c] = in_contact[c] != (c < n)
    count = 0
    eights = marks.view(np.uint64)
    for eight in range(len(eights)):
        if eights[eight] != 0:
            for c in range(8 * eight, 8 * eight + 8):
                if marks[c] != 0 and count <= MOST_DIFFERENCES:
                    places[count] = c
                    count += 1
    return count


@summing_kernel
def products(rows: Real, begin: int, end: int, own: Vector, low: int, high: int, sums: Vector) -> None:
    """Fill ``sums[begin:end]`` with the products of these ``rows`` with ``own`` over columns ``low`` to ``high``."""
    for o in range(begin, end, 4):
        sums[o], sums[o + 1], sums[o + 2], sums[o + 3] = dot_4(
            own[low:high], rows[o, low:], rows[o + 1, low:], rows[o + 2, low:], rows[o + 3, low:]
        )


@block_kernel
def take_in(
    factor: Vector,
    inverse: Vector,
    punch: Vector,
    d: OutOfOrder,
    places: NDArray[np.int64],
    low: int,
    high: int,
    y: Vector,
    overlap: Vector,
) -> bool:
    """Fill slots for those elements at ``places`` that have none.

    Parameters
    ----------
    factor, inverse
        L and its inverse, in panels.
    punch
        h, (n,) or longer, sqrt(Pa/m).
    d
        Slots; changed in place.
    places
        Places of the elements out of order, (k,).
    low, high
        Columns that hold all of them; multiples of 32, so that sums are made up of the same parts for any width.
    y
        L_n^-1 o, (n,), sqrt(m Pa).
    overlap
        o = delta - g, (m,) or longer, m.

    Returns
    -------
    enough
        False if there are not enough slots.
    """
    n = len(y)
    sums = np.empty(2 * HALF)
    for c in places:
        if d.slot[c] >= 0:
            continue
        kind = 0 if c < n else 1
        s, removed, added = d.taken[kind], d.taken[0], d.taken[1]
        if s == kind * HALF + MOST_DIFFERENCES:
            return False
        d.taken[kind], d.slot[c] = s + 1, s
        own = d.rows[s]
        if c < n:
            clear(own[low:c])
            at = row(c) + c
            for t in range(c, n):
                own[t] = inverse[at]
                at += width(t)
            d.load[s], d.punch[s] = dot(y[low:], own[low:]), dot(punch[low:n], own[low:])
            products(d.rows, 0, s + 1, own, low, n, d.gram[s])
            for o in range(s + 1):
                d.gram[s, o] = -d.gram[s, o]
            products(d.rows, HALF, added, own, low, n, sums)
            for o in range(HALF, added):
                d.gram[o, s] = sums[o]
        else:
            mine = factor[row(c) : row(c) + width(c)]
            d.load[s], d.punch[s] = overlap[c] - dot(y, mine), 1.0 - dot(punch[:n], mine)
            target, source = own[low : len(mine)], mine[low:]
            for t in range(len(target)):
                target[t] = source[t]
            clear(own[len(mine) : high])
            products(d.rows, HALF, s + 1, own, n, high, d.gram[s])
            products(d.rows, 0, removed, own, low, n, d.gram[s])
    return True


@block_kernel
def triangular_system(d: OutOfOrder, places: NDArray[np.int64], Q: Real, pivot: Vector) -> tuple[float, float]:
    """Collect the system of the elements out of order and eliminate it.

    Parameters
    ----------
    d
        Slots of these elements.
    places
        Their places, (k,).
    Q
        Filled with U, then l' and r' as two columns, (HALF, width(HALF + 1)). Equations x = 0 make the number of rows a
        multiple of 4. Entries left of the diagonal hold nothing of use.
    pivot
        Filled with the inverse diagonal of U, (HALF,).

    Returns
    -------
    load, punch
        punch.Q^-1 load, Pa, and punch.Q^-1 punch, Pa/m: what these elements add to the sum of all pressures under the
        overlap o, and under a flat punch per unit of approach.
    """
    k = len(places)
    fours = (k + 3) & -4
    w = width(fours + 1)
    slots = np.empty(k, np.int64)
    for a in range(k):
        slots[a] = d.slot[places[a]]
    for a in range(fours):
        equation = Q[a, :w]
        clear(equation)
        equation[a] = 1.0
        if a < k:
            s = slots[a]
            for b in range(a, k):
                equation[b] = d.gram[max(s, slots[b]), min(s, slots[b])]
            equation[fours], equation[fours + 1] = d.load[s], d.punch[s]
    for a in range(0, fours, 4):
        one, two, three, four = Q[a, :w], Q[a + 1, :w], Q[a + 2, :w], Q[a + 3, :w]
        pivot[a] = 1.0 / one[a]
        add_scaled(two, -one[a + 1] * pivot[a], one)
        pivot[a + 1] = 1.0 / two[a + 1]
        f, g = one[a + 2] * pivot[a], two[a + 2] * pivot[a + 1]
        for t in range(w):
            three[t] -= f * one[t] + g * two[t]
        pivot[a + 2] = 1.0 / three[a + 2]
        f, g, h = one[a + 3] * pivot[a], two[a + 3] * pivot[a + 1], three[a + 3] * pivot[a + 2]
        for t in range(w):
            four[t] -= f * one[t] + g * two[t] + h * three[t]
        pivot[a + 3] = 1.0 / four[a + 3]
        for b in range(a + 4, k):
            first = b & -PANEL
            target, r1, r2, r3, r4 = Q[b, first:w], one[first:], two[first:], three[first:], four[first:]
            f, g = one[b] * pivot[a], two[b] * pivot[a + 1]
            h, i = three[b] * pivot[a + 2], four[b] * pivot[a + 3]
            for t in range(len(target)):
                target[t] -= f * r1[t] + g * r2[t] + h * r3[t] + i * r4[t]
    load, punch = 0.0, 0.0
    for a in range(k):
        load += Q[a, fours] * Q[a, fours + 1] * pivot[a]
        punch += Q[a, fours + 1] * Q[a, fours + 1] * pivot[a]
    return load, punch


@block_kernel
def solve_system(
    factor: Vector,
    d: OutOfOrder,
    places: NDArray[np.int64],
    Q: Real,
    pivot: Vector,
    lost: float,
    x: Vector,
    low: int,
    v: Vector,
    w: Vector,
) -> None:
    """Solve Q x = load - lost punch by substitution, and add what x does to ``v`` and ``w``.

    Parameters
    ----------
    factor
        L, in panels.
    d, places, Q, pivot
        Eliminated system, as ``triangular_system`` leaves it.
    lost
        c0 F, m.
    x
        Filled: distances of removed elements, m, and pressures of added ones, Pa, (k or more,).
    low
        Column before which columns of C are zero.
    v
        Filled with L_n^T p of the first n elements, y - c0 F h + C x_R - B^T x_T, (n,), sqrt(m Pa).
    w
        L^T p of all pressures, (columns,). On entry y - c0 F h, then zeros; C x_R and D^T x_T are added.
    """
    n, k = len(v), len(places)
    fours = (k + 3) & -4
    columns = width(fours + 1)
    clear(x[:columns])
    for a in range(k - 1, -1, -1):
        x[a] = (Q[a, fours] - lost * Q[a, fours + 1] - dot(Q[a, :columns], x)) * pivot[a]
    taken = 0
    while taken < k and places[taken] < n:
        add_scaled(w[low:n], x[taken], d.rows[d.slot[places[taken]], low:])
        taken += 1
    for t in range(n):
        v[t] = w[t]
    for a in range(taken, k):
        mine = factor[row(places[a]) : row(places[a]) + width(places[a])]
        add_scaled(v, -x[a], mine)
        add_scaled(w[n : len(mine)], x[a], mine[n:])
