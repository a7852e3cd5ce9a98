"""The force-approach curve of one geometry, kink by kink, without an error of interpolation.

Problem. Solve the contact of ``active_set_kernels`` without compliance, for all approaches from first touch up to a
force. Symbols are the same: K is the weighted influence matrix, w the weights, s the area of an element.

One piece. On a set S of n elements in contact K p = w (delta - g). With the pressures q (Pa/m) of a flat punch on S::

    K q = w,    p(delta) = p(delta_k) + (delta - delta_k) q,    dF/d delta = s w.q.

So the force is linear until S changes. Element c displaces by f_c.p, m, where f_c,b = w_b ``pair(c, b)`` is what unit
pressure on b and on its image does to c (``felt[b, c]``). The next kink is the smaller of::

    entry of c:   g_c - delta + f_c.p = 0,   reached at the rate 1 - f_c.q > 0
    exit of b:    p_b = 0,                   reached at the rate -q_b > 0.

Every f_c.p is at least zero, so c cannot enter before delta = g_c: the candidates are sorted by g, and the search ends
at the first one beyond the earliest kink found.

One kink. H = K^-1 (``inverse``) is bordered or deflated. With a_b = K_eb, h = H a, own = K_ee - a.h for an entry e, and
with h the column of H for an exit l::

    entry:   H <- [H + h h^T / own,  -h / own;  -h^T / own,  1 / own],   q_e = (w_e - a.q) / own,   q <- q - q_e h
    exit:    H <- H - h h^T / h_l,                                       q <- q - h q_l / h_l       (row l left out)

At an entry q_e has the sign of 1 - f_e.q: the pressure of e rises from zero, and dF/d delta rises by s own q_e^2. At
an exit the distance of l opens at the rate -q_l / (h_l w_l), and dF/d delta falls by s q_l^2 / h_l. Either way Eq. (8)
holds after the kink, and F rises.

Termination. The inverse of A of half-spaces has no positive entry off its diagonal and positive row sums r; so, by
block elimination, has H of every set, with row sums q >= r > 0. Then no element ever leaves, F is convex, and there are
at most m kinks. Should a matrix without this property make the path turn in circles, it ends after 4 m kinks; forces
beyond its end are solved one by one (``law_kernels``). Elements that enter together, such as mirror images, follow one
another without an advance and make one kink.

Cost: at each kink 2 n^2 multiply-adds for H and 2 n m' for the search, with m' candidates below the approach; some
2 n^3 in all.

Accuracy: only rounding. ``solve_active_set`` gives the same forces within 1e-8 N up to 400 kN.

Source: parametric principal pivoting for linear complementarity problems (R. W. Cottle, J.-S. Pang, R. E. Stone, The
Linear Complementarity Problem (1992)); this form is derived here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import inner_kernel, kernel
from .active_set_kernels import at_border, pair

BLOCK = 64


class PathSet(NamedTuple):
    """The set S on the way: n elements in contact of m candidates, with room for more."""

    chosen: NDArray[np.int64]
    """Candidates in contact, (m,), the first n of it."""
    inside: NDArray[np.bool_]
    """Whether a candidate is in contact, (m,)."""
    inverse: Real
    """H, (room, room), Pa/m."""
    felt: Real
    """Displacement of all candidates by unit pressure on each element in contact, (room, m), m/Pa."""
    p: Real
    """Pressures, (m,), Pa."""
    q: Real
    """Their rates, (m,), Pa/m."""
    h: Real
    """Scratch, (m,)."""
    a: Real
    """Scratch, (m,)."""


@kernel
def enlarged(array: Real, rows: int, columns: int) -> Real:
    """Copy of an array in the corner of a larger one."""
    larger = np.zeros((rows, columns))
    for i in range(array.shape[0]):  # assigning a slice takes seconds to compile
        for j in range(array.shape[1]):
            larger[i, j] = array[i, j]
    return larger


@inner_kernel
def enter(S: PathSet, n: int, e: int, weight: Real) -> None:
    """Border the inverse of ``n`` elements by candidate ``e``, whose row of ``felt`` is filled."""
    felt, inverse, p, q, h, a = S.felt, S.inverse, S.p, S.q, S.h, S.a
    own = weight[e] * felt[n, e]
    rate = weight[e]
    for b in range(n):
        h[b] = 0.0
    for b in range(n):
        a[b] = weight[e] * felt[b, e]
        row = inverse[b, :n]
        for d in range(n):
            h[d] += a[b] * row[d]
    for b in range(n):
        own -= a[b] * h[b]
        rate -= a[b] * q[b]
    rate /= own
    for b in range(n):
        q[b] -= rate * h[b]
        scaled = h[b] / own
        row = inverse[b, :n]
        for d in range(n):
            row[d] += scaled * h[d]
        inverse[b, n] = -scaled
        inverse[n, b] = -scaled
    inverse[n, n] = 1.0 / own
    q[n], p[n] = rate, 0.0
    S.chosen[n] = e
    S.inside[e] = True


@inner_kernel
def leave(S: PathSet, n: int, out: int) -> None:
    """Deflate the inverse of ``n + 1`` elements by the one at place ``out``, whose place the last one takes."""
    felt, inverse, p, q, h = S.felt, S.inverse, S.p, S.q, S.h
    S.inside[S.chosen[out]] = False
    for b in range(n + 1):
        h[b] = inverse[out, b]
    h[out], h[n] = h[n], h[out]
    for b in range(n + 1):
        inverse[out, b] = inverse[n, b]
    for b in range(n + 1):
        inverse[b, out] = inverse[b, n]
    inverse[out, out] = inverse[n, n]
    S.chosen[out], p[out] = S.chosen[n], p[n]
    for c in range(felt.shape[1]):
        felt[out, c] = felt[n, c]
    q[out], q[n] = q[n], q[out]
    for b in range(n):
        q[b] -= h[b] * q[n] / h[n]
        for d in range(n):
            inverse[b, d] -= h[b] * h[d] / h[n]


@inner_kernel
def next_kink(S: PathSet, n: int, gap: Real, approach: float, end: float) -> tuple[float, int, int]:
    """Find the first kink after ``approach``, m, of ``n`` elements in contact.

    Parameters
    ----------
    S, n
        Set of ``n`` elements in contact, with pressures at ``approach``.
    gap
        Separations of the candidates, rising, (m,), m.
    approach, end
        Approach at the last kink, and the one beyond which no kink is wanted, m.

    Returns
    -------
    following
        Approach at the kink, m; ``end`` if there is none before it.
    entering, leaving
        Candidate that enters, and place in the set of the element that leaves; -1 for none.
    """
    p, q = S.p, S.q
    distance, closing = np.empty(BLOCK), np.empty(BLOCK)
    following, entering, leaving = end, -1, -1
    for b in range(n):
        if q[b] < 0.0 and approach - p[b] / q[b] < following:
            following = approach - p[b] / q[b]
            leaving = b
    for start in range(0, len(gap), BLOCK):
        if gap[start] >= following:
            break
        stop = min(start + BLOCK, len(gap))
        for c in range(stop - start):
            distance[c], closing[c] = gap[start + c] - approach, 1.0
        for b in range(n):
            row = S.felt[b, start:stop]
            for c in range(len(row)):
                distance[c] += p[b] * row[c]
                closing[c] -= q[b] * row[c]
        for c in range(stop - start):
            if not S.inside[start + c] and closing[c] > 0.0:
                meeting = approach + max(distance[c], 0.0) / closing[c]
                if meeting < following:
                    following = meeting
                    entering, leaving = start + c, -1
    return following, entering, leaving


@kernel
def follow_path(
    at_i: NDArray[np.int64],
    at_j: NDArray[np.int64],
    gap: Real,
    shape: tuple[int, int],
    mirrored: bool,
    influence: Real,
    element_area: float,
    largest_force: float,
    largest_pressure: float,
) -> Real:
    """Follow the contact of one geometry from first touch.

    Parameters
    ----------
    at_i, at_j
        Indices of the m candidates along x and y, (m,); with ``mirrored`` from the middle column on.
    gap
        Their separations g, rising, (m,), m.
    shape
        Elements of the area, (nx, ny).
    mirrored, influence, element_area
        As in ``active_set_kernels.solve_active_set``.
    largest_force, largest_pressure
        Force, N, and pressure of an element, Pa, at which the path ends.

    Returns
    -------
    points
        Kinks, (points, 2): approach, m, and force, N, both rising. The first is first touch; the last is at
        ``largest_force`` or ``largest_pressure``, or earlier where the contact reaches the border of the area.
    """
    nx, ny = shape
    centre = ny // 2
    m = len(gap)
    weight = np.ones(m)
    if mirrored:
        for c in range(m):
            if at_j[c] != centre:
                weight[c] = 2.0

    points = np.empty((4 * m + 4, 2))
    approach, force = gap[0], 0.0
    points[0, 0], points[0, 1] = approach, force
    count = 1
    S = PathSet(
        chosen=np.empty(m, np.int64),
        inside=np.zeros(m, np.bool_),
        inverse=np.zeros((64, 64)),
        felt=np.zeros((64, m)),
        p=np.zeros(m),
        q=np.zeros(m),
        h=np.empty(m),
        a=np.empty(m),
    )
    n = 0
    entering, leaving = 0, -1
    for _ in range(4 * m):
        if entering >= 0:
            i, j = at_i[entering], at_j[entering]
            if at_border(nx, ny, mirrored, i, j):
                break
            if n == len(S.inverse):
                S = PathSet(
                    S.chosen,
                    S.inside,
                    enlarged(S.inverse, 2 * n, 2 * n),
                    enlarged(S.felt, 2 * n, m),
                    S.p,
                    S.q,
                    S.h,
                    S.a,
                )
            for c in range(m):
                S.felt[n, c] = weight[entering] * pair(influence, mirrored, centre, at_i[c], at_j[c], i, j)
            enter(S, n, entering, weight)
            n += 1
        elif leaving >= 0:
            n -= 1
            leave(S, n, leaving)

        slope = 0.0
        for b in range(n):
            slope += element_area * weight[S.chosen[b]] * S.q[b]
        end = approach + (largest_force - force) / slope
        for b in range(n):
            if S.q[b] > 0.0:
                end = min(end, approach + (largest_pressure - S.p[b]) / S.q[b])
        following, entering, leaving = next_kink(S, n, gap, approach, end)
        advance = max(following - approach, 0.0)
        for b in range(n):
            S.p[b] += advance * S.q[b]
        approach += advance
        force += advance * slope
        # Elements that enter together (mirror images) make one kink.
        if count > 1 and approach - points[count - 1, 0] <= 1e-12 * (approach - gap[0]):
            count -= 1
        if approach > points[0, 0]:
            points[count, 0], points[count, 1] = approach, force
            count += 1
        if entering < 0 and leaving < 0:
            break
    return points[:count].copy()
