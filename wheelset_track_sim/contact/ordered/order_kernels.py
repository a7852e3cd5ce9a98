"""Elements in the order in which a contact of smooth surfaces takes them in, and what rough surfaces are there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, inner_kernel
from .panel_kernels import PANEL, Vector, dot, row, width

FAR = -1
"""Status: the contact is not nearly that of smooth surfaces, or larger than what is stored."""


class NestedContacts(NamedTuple):
    """M elements in the order in which a smooth contact takes them in; none where no contact is solved."""

    element: NDArray[np.int64]
    """Flat index in the area (nx, ny), (M,)."""
    x: Vector
    """Longitudinal positions, (M,), m."""
    y: Vector
    """Lateral positions, (M,), m."""
    separation: Vector
    """Of the nominal surfaces, (M,), m."""
    beyond: Vector
    """Least separation from each place in the order on, elements that are not in it included, (M + 1,), m."""
    reach: NDArray[np.int64]
    """Rows ahead and behind the middle that the elements up to each place in the order lie in, (M + 1,)."""
    factor: Vector
    """L, in panels, sqrt(m/Pa)."""
    inverse: Vector
    """Inverse of the leading block of L, in panels, half of M."""
    punch: Vector
    """L^-1 times ones, half of M."""
    own: float
    """Influence of an element on itself, m/Pa."""
    far: float
    """Least product of influence and distance: pressures p act at a distance r by at least ``far`` p / r, m^2/Pa."""


@inner_kernel
def gaps_in_order(
    nested: NestedContacts,
    shape: tuple[int, int],
    tread: Real,
    rail_row: NDArray[np.int32],
    rail: Real,
    tread_index: int,
    rail_index: int,
    highest: float,
    approach: float,
    gap: Vector,
) -> int:
    """Fill ``gap``, m, of all elements that can be in contact; returns how many, or FAR if more than there are.

    ``tread`` (n_c, ny) and the rows of ``rail`` that ``rail_row`` (n_r,) names are heights, m, of which no sum within
    the area of ``shape`` (nx, ny) is above ``highest``.
    """
    limit = approach + highest
    beyond = nested.beyond
    low, high = 0, len(beyond)
    while low < high:
        middle = (low + high) // 2
        if beyond[middle] < limit:
            low = middle + 1
        else:
            high = middle
    if low == len(beyond):
        return FAR
    nx, ny = shape
    heights = np.empty(nx * ny)
    reach = nested.reach[low]
    t, r = (tread_index - reach) % len(tread), (rail_index - reach) % len(rail_row)
    for i in range(nx // 2 - reach, nx // 2 + reach + 1):
        sums, of_tread, of_rail = heights[i * ny : (i + 1) * ny], tread[t], rail[rail_row[r]]
        for j in range(ny):
            sums[j] = of_tread[j] + of_rail[j]
        t, r = t + 1, r + 1
        t, r = 0 if t == len(tread) else t, 0 if r == len(rail_row) else r
    for c in range(low):
        gap[c] = nested.separation[c] - heights[nested.element[c]]
    while low > 0 and gap[low - 1] >= approach:
        low -= 1
    return low


@block_kernel
def smooth_contact(
    nested: NestedContacts, gap: Vector, approach: float, compliance: float, element_area: float
) -> tuple[float, float, int]:
    """Deepest gap, m, the gap at the edge of the contact, m, and elements up to there in whole panels, all by Hertz.

    The edge lies where the gap is half the approach (see ``solve_active_set``); of the approach, the compliance takes
    a share that follows from a force of 2/3 of that of a flat punch.
    """
    m = len(gap)
    deepest = np.inf
    for c in range(m):
        if gap[c] < deepest:
            deepest = gap[c]
    edge = 0.5 * (deepest + approach)
    n = 0
    for c in range(m):
        n += gap[c] < edge
    punch = nested.punch[: min(n, len(nested.punch))]
    edge = deepest + (edge - deepest) / (1.0 + 2.0 / 3.0 * compliance * element_area * dot(punch, punch))
    n = 0
    for c in range(m):
        n += gap[c] < edge
    n = (n + n // 20 + PANEL // 2) & -PANEL  # elements in contact whose middle is beyond the edge
    return deepest, edge, n if n <= m else n - PANEL


@block_kernel
def bring_in_far(
    nested: NestedContacts,
    p: Vector,
    w: Vector,
    gap: Vector,
    local: float,
    first: int,
    tolerance: float,
    in_contact: NDArray[np.bool_],
) -> int:
    """Bring elements from ``first`` on that overlap at a ``local`` approach, m, into contact; returns how many.

    ``p`` are all pressures, ``w`` = L^T p, ``gap`` of all that can be in contact. Most need no sum: 1/sqrt is convex,
    so pressures act on a point at least as if all of them stood at their root mean square distance from it.
    """
    total, mean_x, mean_y, square = 0.0, 0.0, 0.0, 0.0
    for c in range(len(p)):
        total += p[c]
        mean_x += p[c] * nested.x[c]
        mean_y += p[c] * nested.y[c]
        square += p[c] * (nested.x[c] ** 2 + nested.y[c] ** 2)
    mean_x, mean_y, square = mean_x / total, mean_y / total, square / total
    least = (nested.far * total) ** 2
    changes = 0
    gaps, x, y, bear = gap[first:], nested.x[first:], nested.y[first:], in_contact[first:]
    for c in range(len(gaps)):
        overlap = local - gaps[c]
        if overlap > 0.0 and not bear[c]:
            distance_2 = x[c] * x[c] + y[c] * y[c] - 2.0 * (x[c] * mean_x + y[c] * mean_y) + square
            if not overlap * overlap * distance_2 <= least:  # NaN, too: without pressure there is no mean
                at = row(first + c)
                if dot(nested.factor[at : at + width(first + c)], w) < overlap - tolerance:
                    bear[c] = True
                    changes += 1
    return changes
