"""Elements in the order in which a contact of smooth surfaces takes them in, and the rough surfaces in that order.

Three steps of ``nested_kernels.solve_in_order`` are here. ``active_set_kernels`` has the symbols.

Candidates. Heights of tread and rail raise no element of the area by more than ``highest``. So an element with a
nominal separation of delta + highest or more cannot be in contact. ``beyond``, the running minimum of the separation
from the far end of the order, rises along it. A bisection finds the first place from which on no element can be in
contact.

Size of the smooth contact. Under spheres of relative radius R (Hertz) the contact reaches out to r^2 = R delta, where
the separation r^2 / (2 R) is half the approach. So n is the number of elements with
g < g_min + (delta - g_min) / 2, and 5 % more. With a compliance, delta - g_min is first reduced by c0 F. Hertz's
F = b (delta - g_min)^(3/2) has the stiffness 3/2 F / (delta - g_min). A flat punch on the present contact has the same
stiffness, s h.h. Hence F = 2/3 s h.h (delta - g_min - c0 F), and what remains of delta - g_min at the contact is
(delta - g_min) / (1 + 2/3 c0 s h.h).

Far elements. The influence at a distance r is at least ``far`` / r. Pressures p at x_J displace a point x by::

    u(x) >= far sum_J p_J / |x - x_J| >= far P / sqrt(|x|^2 - 2 x.m + k),
    P = sum_J p_J,   m = sum_J p_J x_J / P,   k = sum_J p_J |x_J|^2 / P.

The second inequality is Jensen's: 1 / sqrt is convex, and the root is the root mean square distance. An element whose
overlap is below this bound is not in contact, whatever its true displacement; only for the others is that summed.

Source: K. L. Johnson, Contact Mechanics (1985), Chapter 4, for Hertz; the rest is derived here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...runtime.arrays import Real
from ...runtime.jit import block_kernel, inner_kernel
from .panel_kernels import PANEL, Vector, dot, row, width

FAR = -1
"""Status: the contact is not nearly smooth, or larger than the stored factor."""


class NestedContacts(NamedTuple):
    """M elements in the order in which a smooth contact takes them in; M = 0 where no contact is solved."""

    element: NDArray[np.int64]
    """Flat index in the area (nx, ny), (M,)."""
    x: Vector
    """Longitudinal positions, (M,), m."""
    y: Vector
    """Lateral positions, (M,), m."""
    separation: Vector
    """Of the nominal surfaces, (M,), m."""
    beyond: Vector
    """Least separation from each place in the order on, including elements that are not in it, (M + 1,), m."""
    reach: NDArray[np.int64]
    """Distance along x from the middle of the area to the farthest element before each place, in elements, (M + 1,)."""
    factor: Vector
    """Cholesky factor L of the influence matrix, in panels, sqrt(m/Pa)."""
    inverse: Vector
    """Inverse of the leading block of L, M / 2 rows in whole panels, sqrt(Pa/m)."""
    punch: Vector
    """h = L^-1 1, as long as the inverse, sqrt(Pa/m)."""
    own: float
    """Influence A_00 of an element on itself, m/Pa."""
    far: float
    """Least product of influence and distance between two elements, m^2/Pa."""


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
    """Separations g of all elements that can be in contact.

    Parameters
    ----------
    nested
        Elements in their order.
    shape
        Elements of the area, (nx, ny).
    tread
        Heights of the tread, (n_c, ny), m.
    rail_row, rail
        Row of ``rail`` at each rail position, (n_r,), and the heights of these rows, (rows, ny), m.
    tread_index, rail_index
        Positions at the middle of the area.
    highest
        No sum of both heights within the area is above it, m.
    approach
        delta, m.
    gap
        The first m entries are filled, m.

    Returns
    -------
    m
        Number of candidates; FAR if the order may not hold all of them.
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
    """Smooth contact that is nearest to a rough one.

    Parameters
    ----------
    nested
        Elements in their order.
    gap
        Separations g of the candidates, (m,), m.
    approach, compliance, element_area
        delta, m, c0, m/N, and s, m^2.

    Returns
    -------
    deepest
        Least gap, m.
    edge
        Gap at the edge of the contact, m.
    n
        Number of elements, in whole panels, at most m.
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
    n = (n + n // 20 + PANEL // 2) & -PANEL  # some elements are in contact although their middle is beyond the edge
    return deepest, edge, min(n, m & -PANEL)


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
    """Bring elements that overlap into contact, far from the edge; returns how many.

    Parameters
    ----------
    nested
        Elements in their order.
    p
        Pressures of the candidates, (m,), Pa.
    w
        w = L^T p, sqrt(m Pa), as wide as the rows of L in use.
    gap
        Separations g, (m,), m.
    local
        delta - c0 F, m.
    first
        Place from which on elements are looked at.
    tolerance
        Overlap that counts as none, m.
    in_contact
        By place, (m,); changed in place.
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
