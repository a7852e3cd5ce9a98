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

THIRD_ORDER was worked out from the solver: with roughness from 10 dB below the limit of ISO 3095 to 6 dB above it on
both surfaces, under 20 to 350 kN, nine contacts of ten are within E + 1 N, and all are within ten times that
(``tests/validation/test_contact_filter.py``).

Inside. Elements far within the contact count as open without a look. A dip there, of amplitude a and wavelength l,
reduces the pressure by pi E* a / l (K. L. Johnson, Contact Mechanics (1985), Section 13.2), and lets go of its elements
if that is more than they bear. Let d be what the heights at a distance b of 3 mm ahead, behind, to the left and to the
right are above that of an element, in sum: 2 a (1 - cos(2 pi b / l)). Then 0.45 E* d / b is within a quarter of the
pressure for waves from 5 to 20 mm. The largest pressure is 3/2 F / (n s) (Hertz). In the middle a dip may take
LEAST_PRESSURE of it. Towards the edge the hinges tell of dips that are not narrow, and narrow ones must not be deeper
than DEEPEST of the approach.

Slope. On a slope s, a wheel of radius R touches s R ahead: with a long wave, by whole elements. Its contact is that of
the smooth surfaces there, and what is left of the slope is below half an element, 1.2e-3. So the heights are taken
beside nominal surfaces that are moved by a whole number of elements. A is the same wherever the contact is.

Window. Hinges are evaluated in blocks of eight, inwards until a whole block is open, outwards until one is shut, and
each way for CLEAR standard deviations of rho, in delta_c, beyond the edge. All further in are one hinge: their
stiffness, their mean of heights and of approach are tabulated. X is found by Newton's method: X + c0 F(X) is convex and
piecewise linear, so it ends exactly after a few steps.

The solver takes over (status FAR) where E exceeds the bound, in small contacts, at dips, and where the window grows too
large. The decision depends on the heights, approach and compliance of the step alone.

Cost: n multiply-adds for each hinge, in single precision, 30 to 100 of them; heights count from the middle of the area,
so rounding is 1e-6 of the roughness.

Source: derived here. Contacts that are replaced by independent springs are known from the method of dimensionality
reduction (V. L. Popov, M. Hess, Method of Dimensionality Reduction in Contact Mechanics and Friction (2015)).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import inner_kernel, kernel, summing_kernel
from .order_kernels import FAR

FILTERED = 5
"""Status: the force is that of the filter."""
BLOCK = 8
"""Hinges that are evaluated together."""
VECTOR = 8
"""Elements in which a dip is sought at a time: with a count that is known the compiler needs no remainder."""
CLEAR = 2.0
"""Standard deviations of rho by which the window reaches beyond the edge."""
HALF_WINDOW = 2
"""Blocks on each side of the edge that are always evaluated."""
AHEAD = 80
"""Elements beyond a smooth contact that may come in."""
MOST_BLOCKS = 24
"""Largest window."""
SLOPE = 6
"""Elements ahead and behind over which the slope is taken."""
LEAST = 48
"""Fewest elements of a contact: below some 10 kN it is solved."""
THIRD_ORDER = 0.4
"""Share of sqrt(D^3 / F) that is the estimate."""
INNER = 0.6
"""Half a side of a rectangle within the ellipse of contact, share of the axes."""
LEAST_PRESSURE = 0.6
"""Share of the largest pressure that a dip may take there."""
DEEPEST = 0.25
"""Depth of an element below the mean, share of the approach, beyond which the contact is solved."""

Single = NDArray[np.float32]


class Hinges(NamedTuple):
    """Hinges of the first M elements in the order of the nested solver, M in whole blocks; M = 0 without a filter.

    The first axis is the wheel; it has the length 1 where both contacts are alike.
    """

    weights: Single
    """Weights of the heights in rho_c, M rows, then those of the mean over all hinges before each block, M / BLOCK
    rows; (wheels, M + M / BLOCK, M). Each row but the first of the means adds up to 1."""
    opening: Real
    """delta_c, m, and sigma_c, N/m, (wheels, 2, M)."""
    blocks: Real
    """Of all hinges before each block: mean of delta_c, m, and sum of sigma_c, N/m; approach, m, and force, N, of the
    smooth contact that has just them; (wheels, 4, M / BLOCK)."""
    element: NDArray[np.uint32]
    """Flat index in the area (nx, ny), (wheels, M); unsigned, for an index that may be negative takes longer."""
    extent: NDArray[np.int64]
    """Distances from the middle of the area to the farthest element before each place, along and across, in elements,
    (wheels, 2, M + 1)."""
    fall: Real
    """Separation of the nominal surfaces in the middle across, from nx elements behind to nx ahead, (wheels, 2 nx + 1),
    m."""
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


@summing_kernel
def out_of_order(depth: Real, stiffness: Real, X: float, sign: float) -> float:
    """Force, N, of hinges that are open (``sign`` 1) or of the suction on those that are shut (-1), at X, m."""
    force = 0.0
    for c in range(len(depth)):
        reach = sign * (X + depth[c])
        force += (stiffness[c] if reach > 0.0 else 0.0) * reach
    return force


@summing_kernel
def spread(depth: Real, delta: Real) -> tuple[float, float]:
    """Mean and standard deviation, m, of rho = depth + delta (n,)."""
    total, square = 0.0, 0.0
    for c in range(len(depth)):
        rho = depth[c] + delta[c]
        total += rho
        square += rho * rho
    mean = total / len(depth)
    return mean, np.sqrt(max(square / len(depth) - mean * mean, 0.0))


@inner_kernel
def blocks_before(edge: Real, borne: Real, compliance: float, approach: float) -> int:
    """Blocks of hinges that a smooth contact has opened at ``approach``, m; 0 for NaN.

    ``edge``, m, and ``borne``, N, are those of ``Hinges.blocks``; ``compliance`` is c0, m/N.
    """
    low, high = 0, len(edge)
    while low < high:
        middle = (low + high) // 2
        if edge[middle] + compliance * borne[middle] <= approach:
            low = middle + 1
        else:
            high = middle
    return low


@inner_kernel
def open_to(
    depth: Real, stiffness: Real, held: float, inside: float, compliance: float, top: float, X: float
) -> tuple[float, float]:
    """Solve X + c0 F(X) = top for the hinges of a window and those inside it, from X on.

    Parameters
    ----------
    depth, stiffness
        rho - delta, m, and sigma, N/m, of the hinges, (n,).
    held, inside
        The same of all hinges inside the window, as one.
    compliance, top, X
        c0, m/N, delta at the height of the middle, m, and the first guess, m.

    Returns
    -------
    force, X
        F, N, and X, m.
    """
    force = 0.0
    for _ in range(len(depth) + 2):
        force, slope = open_hinges(depth, stiffness, X)
        force += held * (X + inside)
        step = (X + compliance * force - top) / (1.0 + compliance * (slope + held))
        X -= step
        if abs(step) <= 1e-15:
            break
    return force, X


@inner_kernel
def heights_in_order(
    element: NDArray[np.uint32],
    shape: tuple[int, int],
    tread: Real,
    rail_row: NDArray[np.int32],
    rail: Real,
    tread_index: int,
    rail_index: int,
    middle: float,
    fall: Real,
    shift: int,
    reach: int,
    aside: int,
    heights: Single,
    ordered: Single,
) -> None:
    """Fill the heights of both surfaces over ``middle``, m, beside surfaces that touch ``shift`` elements ahead.

    ``fall`` is that of ``Hinges``, and the indices are those of the middle. ``heights`` (nx ny,) are by position, up to
    ``reach`` elements along and ``aside`` across from the middle; ``ordered`` (m,) are in order.
    """
    nx, ny = shape
    left, right = ny // 2 - aside, ny // 2 + aside + 1
    t, r = (tread_index - reach) % len(tread), (rail_index - reach) % len(rail_row)
    for i in range(nx // 2 - reach, nx // 2 + reach + 1):
        sums = heights[i * ny + left : i * ny + right]
        of_tread, of_rail = tread[t, left:right], rail[rail_row[r], left:right]
        level = middle + (fall[nx + i - nx // 2 + shift] - fall[nx + i - nx // 2])
        for j in range(len(sums)):
            sums[j] = np.float32(of_tread[j] + of_rail[j] - level)
        t, r = t + 1, r + 1
        t, r = 0 if t == len(tread) else t, 0 if r == len(rail_row) else r
    for c in range(len(ordered)):
        ordered[c] = heights[element[c]]


@summing_kernel
def lowest(heights: Single) -> float:
    """Least of some heights, m."""
    least = np.float32(np.inf)
    for t in range(len(heights)):
        least = heights[t] if heights[t] < least else least
    return float(least)


@summing_kernel
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


@inner_kernel
def turned(index: int, length: int) -> int:
    """``index`` modulo ``length``, without a division where it is within."""
    return index if 0 <= index < length else index % length


@inner_kernel
def elements_ahead(
    fall: Real, tread: Real, rail_row: NDArray[np.int32], rail: Real, t: int, r: int, ny: int, half: int
) -> int:
    """Elements, ``half`` at most, by which wheel and rail touch further ahead on a slope.

    ``fall`` is that of ``Hinges``; ``t`` and ``r``, within the lengths of tread and rail, are the indices in the
    middle. The slope is that of a straight line through the heights SLOPE elements, and half of that, ahead and behind.
    """
    moment, square = 0.0, 0.0
    for u in (SLOPE // 2, SLOPE):
        t_ahead, t_behind = turned(t + u, len(tread)), turned(t - u, len(tread))
        r_ahead, r_behind = turned(r + u, len(rail_row)), turned(r - u, len(rail_row))
        rise = tread[t_ahead, ny // 2] - tread[t_behind, ny // 2]
        moment += u * (rise + rail[rail_row[r_ahead], ny // 2] - rail[rail_row[r_behind], ny // 2])
        square += 2.0 * u * u
    ahead = moment / square / (2.0 * fall[len(fall) // 2 + 1])
    return int(np.rint(min(max(ahead, -float(half)), float(half))))


@kernel
def filtered_force(
    hinges: Hinges,
    wheel: int,
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
    hinges, wheel
        Those of the wheel, 0 or 1, are used.
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
    which = wheel % len(hinges.weights)
    fall = hinges.fall[which]
    t, r = tread_index % len(tread), rail_index % len(rail_row)
    shift = elements_ahead(fall, tread, rail_row, rail, t, r, ny, nx // 2)
    t, r = (t + shift) % len(tread), (r + shift) % len(rail_row)
    middle = tread[t, ny // 2] + rail[rail_row[r], ny // 2] - (fall[nx + shift] - fall[nx])
    # The smooth contact at the height of the middle, and its mean of heights.
    weights, opening, extent = hinges.weights[which], hinges.opening[which], hinges.extent[which]
    mean, held, edge, borne = hinges.blocks[which]
    M = opening.shape[1]
    top = approach + middle
    low = blocks_before(edge, borne, compliance, top) - 1
    n = low * BLOCK
    ahead = min(n + AHEAD, M)
    if n < LEAST or low == len(edge) - 1:
        return np.nan, np.nan, FAR
    reach, aside = extent[0, ahead], extent[1, ahead]
    memory = np.empty(MOST_BLOCKS * BLOCK + (nx * ny + ahead + 1) // 2)  # at once, for it takes 40 ns
    depth, singles = memory[: MOST_BLOCKS * BLOCK], memory[MOST_BLOCKS * BLOCK :].view(np.float32)
    heights, ordered = singles[: nx * ny], singles[nx * ny : nx * ny + ahead]
    heights_in_order(
        hinges.element[which],
        shape,
        tread,
        rail_row,
        rail,
        t,
        r,
        middle,
        fall,
        shift,
        reach,
        aside,
        heights,
        ordered,
    )
    X = edge[low] + mean_of(weights[M + low], ordered[:n])
    place = blocks_before(edge, borne, 0.0, X)
    first, last = place - HALF_WINDOW, place + HALF_WINDOW
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
            means_of(weights, ordered[: c + BLOCK], c, depth[at : at + BLOCK])
            for q in range(BLOCK):
                depth[at + q] -= opening[0, c + q]
        begin, end = first, last
        inside = mean_of(weights[M + first], ordered[: first * BLOCK]) - mean[first]
        near = depth[(first - base) * BLOCK : (last - base) * BLOCK]
        own = opening[1, first * BLOCK : last * BLOCK]
        force, X = open_to(near, own, held[first], inside, compliance, top, X)
        delta = opening[0, first * BLOCK : last * BLOCK]
        mean_rho, deviation = spread(near, delta)
        opened = X + mean_rho - delta[0] > CLEAR * deviation
        shut = delta[len(delta) - 1] - X - mean_rho > CLEAR * deviation
        for q in range(BLOCK):
            opened &= X + near[q] > 0.0
            shut &= X + near[len(near) - BLOCK + q] <= 0.0
        if opened and shut:
            break
        first, last = first if opened else first - 1, last if shut else last + 1
    if not (opened and shut and force > 0.0):
        return np.nan, np.nan, FAR
    n = 0
    for c in range(len(near)):
        n += X + near[c] > 0.0
    D = out_of_order(near[:n], own[:n], X, -1.0) + out_of_order(near[n:], own[n:], X, 1.0)
    estimate = THIRD_ORDER * np.sqrt(D**3 / force)
    if not estimate <= bound:
        return np.nan, estimate, FAR
    n += first * BLOCK
    level = inside + mean[first]
    half_i = min(int(INNER * extent[0, n]), reach - hinges.along)
    half_j = min(int(INNER * extent[1, n]) + VECTOR // 4, aside - hinges.across)
    half_j -= half_j % (VECTOR // 2)
    dip = deepest_dip(heights, shape, half_i, half_j, hinges.along, hinges.across)
    suction = hinges.modulus * dip > LEAST_PRESSURE * 1.5 * force / (n * element_area)
    if suction or level - lowest(ordered[:n]) > DEEPEST * (X + level):
        return np.nan, estimate, FAR
    return force, estimate, FILTERED
