"""The contact filter: the force of a nearly smooth contact as a sum of hinges, without solving for its set.

Problem. ``active_set_kernels`` states it and has the symbols; w = 1 here. The elements are numbered in the order in
which a contact of smooth surfaces takes them in, and A = L L^T in that order, as in ``nested_kernels``. Heights r of
the surfaces, beside the nominal separation g, are of the order of the roughness.

Hinges. With y = L^-1 (delta - g + r), h = L^-1 1 and p = L^-T z, the energy of a contact is s (z.z / 2 - z.y) and its
force F = s h.z. Without the condition p >= 0 the first n elements have z = y. In a smooth contact that has grown to n
elements, z_c = y_c = h_c (delta - delta_c) >= 0 for c < n, where delta_c is the approach at which c comes into contact;
all later y_c are negative. The filter takes the same for rough surfaces, element by element::

    z_c = max(0, y_c)

    F = sum_c sigma_c max(0, X + rho_c - delta_c),    X = delta - c0 F
    sigma_c = s h_c^2,   delta_c = (L^-1 g)_c / h_c,   rho_c = (L^-1 r)_c / h_c

Each element is a hinge: it opens at the approach delta_c, moved by rho_c, a mean of the heights at the edge of the
contact with c as its last element (the weights of a row of L^-1 / h_c add up to 1), and adds sigma_c to the stiffness.

Order. For heights that are constant the sum is exact, since F depends on X + r alone. For small r the set is the first
n elements, and F = (sum_{c<n} sigma_c) X + ... + w.r with w = s A_CC^-1 1: exact to first order. The term of second
order is what the hinges near the edge make of it. It equals that of the energy: with r' = r - w.r / sum w,

    F = F_smooth(X + w.r / sum w) + 1/2 d/d delta (s r'.A_CC^-1 r') + ...,

for A_CC^-1 of the next larger set is A_CC^-1 + (row of L^-1)^T (row of L^-1), and the derivative, taken over the kinks
between two approaches, is the sum of s (L^-1 r')_c^2 over the elements that come in there: the same as that of hinges.

What is neglected. Where c is apart but a later e in contact, p_c = (L^-1)_ec z_e is suction, and to first order in the
coupling t = -(L^-1)_ec / (L^-1)_cc, which is at least 0, F is off by s t (h_c z_e - h_e |y_c|). The number of such
pairs grows with the square of the heights, so this is of third order. What the hinges out of order add to the force::

    D = sum (sigma |X + rho - delta|) over the hinges that are shut before place n, and open from n on,

with n the number of open ones, is of second order. So the error is estimated as

    E = THIRD_ORDER sqrt(D^3 / F).

THIRD_ORDER was worked out from the solver (``tests/validation/test_contact_filter.py``): E is the largest error of
ninety-five contacts of a hundred, from 20 to 350 kN and up to 6 dB above the limit of ISO 3095 on both surfaces.

Inside. Elements far within the contact count as open without a look. A dip there, of amplitude a and wavelength l,
reduces the pressure by pi E* a / l (K. L. Johnson, Contact Mechanics (1985), Section 13.2), and lets go of its elements
if that is more than they bear. Let d be what the heights at a distance b of 3 mm ahead, behind, to the left and to the
right are above that of an element, in sum: 2 a (1 - cos(2 pi b / l)). Then 0.45 E* d / b is within a quarter of the
pressure for waves from 5 to 20 mm. It must be below LEAST_PRESSURE of the largest pressure of Hertz, 3/2 F / (n s).

Window. Hinges are evaluated from 8-row block to block, inwards until a whole block is open, outwards until one is shut.
All further in are one hinge: their stiffness, their mean of heights (``inner``) and mean approach are tabulated. X is
found by Newton's method: X + c0 F(X) is convex and piecewise linear, so it ends exactly after a few steps.

The solver takes over (status FAR) where E exceeds the bound, in small contacts, at dips, and where the window grows too
large. The decision depends on the heights, approach and compliance of the step alone.

Cost: n multiply-adds for each hinge, in single precision, 30 to 100 of them; heights count from the middle of the area,
so rounding is 1e-6 of the roughness.

Source: derived here. The second-order term agrees with a fit to the solver; the order of growth is that of the method
of dimensionality reduction (V. L. Popov, M. Hess, Method of Dimensionality Reduction in Contact Mechanics and Friction
(2015)), which replaces a contact by independent springs, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, inner_kernel, summing_kernel
from .order_kernels import FAR, NestedContacts

FILTERED = 5
"""Status: the force is that of the filter."""
BLOCK = 8
"""Hinges that are evaluated together."""
VECTOR = 8
"""Heights that are added at a time: with a count that is known the compiler needs no remainder."""
CLEAR = 2 * BLOCK
"""Hinges at each end of the window that must be open, or shut."""
HALF_WINDOW = 3
"""Blocks on each side of the edge that are always evaluated."""
AHEAD = 80
"""Elements beyond a smooth contact that may come in."""
MOST_BLOCKS = 24
"""Largest window."""
LEAST = 48
"""Fewest elements of a contact: below some 10 kN it is solved."""
THIRD_ORDER = 0.25
"""Share of sqrt(D^3 / F) that is the estimate."""
LEAST_PRESSURE = 0.6
"""Share of the largest pressure that a dip within the contact may take."""

Single = NDArray[np.float32]


class Hinges(NamedTuple):
    """Hinges of the first M elements in the order of the nested solver, M in whole blocks; M = 0 without a filter."""

    rho: Single
    """Weights of the heights in rho_c, (M, M); each row adds up to 1."""
    inner: Single
    """Weights of the heights of all hinges before each block, likewise, (M / BLOCK, M)."""
    opening: Real
    """delta_c, m, and sigma_c, N/m, (M, 2)."""
    before: Real
    """Of all hinges before each block: mean of delta_c, m, and sum of sigma_c, N/m, (M / BLOCK, 2)."""
    edge: Real
    """Approach, m, and force, N, of the smooth contact that has all hinges before each block, (M / BLOCK, 2)."""
    aside: NDArray[np.int64]
    """Distance across from the middle of the area to the farthest element before each place, in elements, (M + 1,)."""
    modulus: float
    """0.45 E* / b, N/m^3."""
    along: int
    """b in elements along the track."""
    across: int
    """b in elements across."""


@summing_kernel
def mean_of(weights: Single, heights: Single) -> float:
    """Sum of weights times heights over the length of ``heights``, m."""
    total = np.float32(0.0)
    for t in range(len(heights)):
        total += weights[t] * heights[t]
    return float(total)


@summing_kernel
def means_of(weights: Single, heights: Single, first: int, moved: Real) -> None:
    """Fill ``moved`` (BLOCK,) with rho, m, of the hinges from ``first`` on; heights reach to their last element."""
    for q in range(0, BLOCK, 4):
        a, b, c, d = weights[first + q], weights[first + q + 1], weights[first + q + 2], weights[first + q + 3]
        total_a, total_b, total_c, total_d = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
        for t in range(len(heights)):
            height = heights[t]
            total_a += a[t] * height
            total_b += b[t] * height
            total_c += c[t] * height
            total_d += d[t] * height
        moved[q], moved[q + 1], moved[q + 2], moved[q + 3] = total_a, total_b, total_c, total_d


@summing_kernel
def open_hinges(depth: Real, stiffness: Real, X: float) -> tuple[float, float]:
    """Force, N, and stiffness, N/m, of hinges with openings -depth (n,), m, at the approach X, m."""
    force, total = 0.0, 0.0
    for c in range(len(depth)):
        reach = X + depth[c]
        share = stiffness[c] if reach > 0.0 else 0.0
        force += share * reach
        total += share
    return force, total


@inner_kernel
def blocks_before(hinges: Hinges, X: float) -> int:
    """Blocks of hinges that a smooth contact of approach X, m, has opened; all of them if it is beyond the last."""
    edge = hinges.edge
    low, high = 0, len(edge)
    while low < high:
        middle = (low + high) // 2
        if edge[middle, 0] <= X:
            low = middle + 1
        else:
            high = middle
    return low


@block_kernel
def heights_in_order(
    nested: NestedContacts,
    shape: tuple[int, int],
    tread: Real,
    rail_row: NDArray[np.int32],
    rail: Real,
    tread_index: int,
    rail_index: int,
    middle: float,
    reach: int,
    left: int,
    width: int,
    heights: Single,
    ordered: Single,
) -> None:
    """Fill the heights of both surfaces over ``middle``, m.

    ``heights`` (nx ny,) are by position, up to ``reach`` elements along from the middle, and across ``width`` of them,
    a multiple of VECTOR, from ``left`` on; ``ordered`` (m,) in order.
    """
    nx, ny = shape
    t, r = (tread_index - reach) % len(tread), (rail_index - reach) % len(rail_row)
    for i in range(nx // 2 - reach, nx // 2 + reach + 1):
        sums, of_tread, of_rail = heights[i * ny + left :], tread[t, left:], rail[rail_row[r], left:]
        for start in range(0, width, VECTOR):
            for j in range(start, start + VECTOR):
                sums[j] = np.float32(of_tread[j] + of_rail[j] - middle)
        t, r = t + 1, r + 1
        t, r = 0 if t == len(tread) else t, 0 if r == len(rail_row) else r
    for c in range(len(ordered)):
        ordered[c] = heights[nested.element[c]]


@block_kernel
def deepest_dip(heights: Single, shape: tuple[int, int], half_i: int, half_j: int, along: int, across: int) -> float:
    """Four times the largest depth, m, of an element below those at a distance, around the middle of the area."""
    nx, ny = shape
    most = np.float32(0.0)
    for i in range(nx // 2 - half_i, nx // 2 + half_i + 1):
        for start in range(i * ny + ny // 2 - half_j, i * ny + ny // 2 + half_j, VECTOR):
            own = heights[start : start + VECTOR]
            behind, ahead = heights[start - along * ny :], heights[start + along * ny :]
            right, left = heights[start - across :], heights[start + across :]
            for j in range(VECTOR):
                dip = behind[j] + ahead[j] + right[j] + left[j] - np.float32(4.0) * own[j]
                most = dip if dip > most else most
    return float(most)


@block_kernel
def filtered_force(
    hinges: Hinges,
    nested: NestedContacts,
    shape: tuple[int, int],
    tread: Real,
    rail_row: NDArray[np.int32],
    rail: Real,
    tread_index: int,
    rail_index: int,
    element_area: float,
    approach: float,
    compliance: float,
    bound: float,
) -> tuple[float, float, int]:
    """Force of a nearly smooth contact.

    Parameters
    ----------
    hinges, nested
        Of the wheel.
    shape, tread, rail_row, rail, tread_index, rail_index
        As in ``order_kernels.gaps_in_order``.
    element_area
        s, m^2.
    approach, compliance
        delta, m, and c0, m/N.
    bound
        Largest estimate of the error, N.

    Returns
    -------
    force
        F, N.
    estimate
        E, N.
    status
        FILTERED, or FAR if the contact is not for this method.
    """
    nx, ny = shape
    t, r = tread_index % len(tread), rail_index % len(rail_row)
    middle = tread[t, ny // 2] + rail[rail_row[r], ny // 2]
    # The smooth contact at the height of the middle, and its mean of heights.
    edge, before = hinges.edge, hinges.before
    low, high, top = 0, len(edge) - 1, approach + middle
    if not edge[high, 0] + compliance * edge[high, 1] > top:  # NaN, too
        return np.nan, np.nan, FAR
    while high - low > 1:
        centre = (low + high) // 2
        if edge[centre, 0] + compliance * edge[centre, 1] <= top:
            low = centre
        else:
            high = centre
    X = edge[low, 0]
    n = low * BLOCK
    ahead = min(n + AHEAD, len(hinges.opening))
    if n < LEAST:
        return np.nan, np.nan, FAR
    reach, aside = nested.reach[ahead], hinges.aside[ahead]
    width = (2 * aside + VECTOR) // VECTOR * VECTOR
    left = min(ny // 2 - aside, ny - width)
    if left < 0:
        return np.nan, np.nan, FAR
    heights, ordered = np.empty(nx * ny, np.float32), np.empty(ahead, np.float32)
    heights_in_order(
        nested, shape, tread, rail_row, rail, tread_index, rail_index, middle, reach, left, width, heights, ordered
    )
    X += mean_of(hinges.inner[low], ordered[:n])
    place = blocks_before(hinges, X)
    first, last = place - HALF_WINDOW, place + HALF_WINDOW
    size = MOST_BLOCKS * BLOCK
    depth, stiffness = np.empty(size), np.empty(size)
    # The window may grow to both sides of where it begins.
    base = first - MOST_BLOCKS // 2
    begin, end = first, first
    force = 0.0
    for _ in range(2 * MOST_BLOCKS):
        if first * BLOCK < LEAST // 2 or last * BLOCK > ahead or first <= base or last >= base + MOST_BLOCKS:
            return np.nan, np.nan, FAR
        for block in range(first, last):
            if begin <= block < end:
                continue
            c, at = block * BLOCK, (block - base) * BLOCK
            means_of(hinges.rho, ordered[: c + BLOCK], c, depth[at : at + BLOCK])
            for q in range(BLOCK):
                depth[at + q] -= hinges.opening[c + q, 0]
                stiffness[at + q] = hinges.opening[c + q, 1]
        begin, end = first, last
        inside = mean_of(hinges.inner[first], ordered[: first * BLOCK]) - before[first, 0]
        part = slice((first - base) * BLOCK, (last - base) * BLOCK)
        held, near, own = before[first, 1], depth[part], stiffness[part]
        for _ in range(len(near) + 2):
            force, slope = open_hinges(near, own, X)
            force += held * (X + inside)
            step = (X + compliance * force - top) / (1.0 + compliance * (slope + held))
            X -= step
            if abs(step) <= 1e-15:
                break
        opened = shut = True
        for q in range(CLEAR):
            opened &= X + near[q] > 0.0
            shut &= X + near[len(near) - CLEAR + q] <= 0.0
        if opened and shut:
            break
        first, last = first if opened else first - 1, last if shut else last + 1
    if not (opened and shut and force > 0.0):
        return np.nan, np.nan, FAR
    n, out_of_order = 0, 0.0
    for c in range(len(near)):
        n += X + near[c] > 0.0
    for c in range(len(near)):
        reached = X + near[c]
        if (reached > 0.0) != (c < n):
            out_of_order += own[c] * abs(reached)
    estimate = THIRD_ORDER * np.sqrt(out_of_order**3 / force)
    if not estimate <= bound:
        return np.nan, estimate, FAR
    n += first * BLOCK
    # Within a rectangle in the ellipse of the contact.
    half_i = int(0.6 * nested.reach[n])
    half_j = (int(0.6 * hinges.aside[n]) + VECTOR // 4) // (VECTOR // 2) * (VECTOR // 2)
    half_i, half_j = min(half_i, reach - hinges.along), min(half_j, aside - hinges.across)
    dip = deepest_dip(heights, shape, half_i, half_j, hinges.along, hinges.across)
    if hinges.modulus * dip > LEAST_PRESSURE * 1.5 * force / (n * element_area):
        return np.nan, estimate, FAR
    return force, estimate, FILTERED
