"""What sets a contact of rough surfaces apart from one of smooth surfaces: elements out of order, and their system."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, summing_kernel
from .panel_kernels import PANEL, Vector, add_scaled, clear, dot, dot_4, row, width

MOST_DIFFERENCES = 96
"""Beyond, a factorisation of all elements in contact takes no longer."""

HALF = MOST_DIFFERENCES + 4
"""Slots of each kind: products are taken four at a time, over some that are not there yet."""


class OutOfOrder(NamedTuple):
    """What is worked out about elements out of order; those removed have slots from 0 on, those added from HALF on."""

    taken: NDArray[np.int64]
    """Slots taken by removed and by added elements, (2,)."""
    slot: NDArray[np.int64]
    """Of each place in the order; -1 where there is none, (m,)."""
    rows: Real
    """By slot: column of L^-1 of a removed element, row of L of an added one, between the columns in use."""
    gram: Real
    """Matrix of the system, by slots, below the diagonal and on it."""
    load: Vector
    """Right-hand side of the overlap, by slot."""
    punch: Vector
    """Right-hand side of a flat punch, by slot."""


@block_kernel
def no_differences(m: int, columns: int) -> OutOfOrder:
    """None, of ``m`` elements, with rows of a number of ``columns``."""
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
    """Take all slots away."""
    d.taken[0], d.taken[1] = 0, HALF
    for c in range(len(d.slot)):
        d.slot[c] = -1


@block_kernel
def out_of_order(in_contact: NDArray[np.bool_], n: int, marks: NDArray[np.uint8], places: NDArray[np.int64]) -> int:
    """Fill ``places`` with those before ``n`` that are not in contact and those beyond that are; returns the number.

    Beyond MOST_DIFFERENCES, counting ends. ``marks`` is as long as ``in_contact`` or longer, in eights, and zero at its
    end.
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
    """Fill ``sums[begin:end]`` with products of those ``rows`` with ``own``, from column ``low`` to ``high``."""
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
    """Work out what the elements at ``places`` need that have no slot yet; False if there are not enough slots.

    Places lie between ``low`` and ``high``, beyond which products are zero.
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
    """Put the system of the elements at ``places`` (k,) into ``Q`` and eliminate, with inverse pivots.

    It is filled up to fours with equations of their own, and columns with its right-hand sides follow. Rows stay
    symmetric only to the right of the diagonal, in sixteens. Returns what the elements add to the sums of pressures,
    of the overlap and of a flat punch.
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
    """Solve the system for ``x``, with an approach that is ``lost``, and add its effects to ``v`` and ``w``.

    ``v`` (n,) belongs to the elements before n, and ``w`` to all.
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
