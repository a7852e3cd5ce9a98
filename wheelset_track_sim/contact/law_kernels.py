"""The contact law of the coupled step: approach in, force out, for both wheels.

Problem. Find the force F, N, with F = f(delta - c0 F). f is the force-approach curve of the surfaces under a wheel at
this step. delta, m, is the approach without the force of this step; c0, m/N, is what that force adds to the
displacements. f is zero up to first touch, then rises. So f(delta - c0 F) falls with F, and exactly one F solves this.

Four methods are tried in this order:

1. A table (``tabulated_force``). ``path_kernels`` follows f from kink to kink, so f is linear between the kinks
   (x_k, f_k). A bisection finds the segment whose ends x_k + c0 f_k enclose delta; t is its slope. F is exact::

       F = (f_k + t (delta - x_k)) / (1 + c0 t)

2. The contact filter (``ordered.hinge_kernels``), without a table, where its estimate of its error is small.
3. The nested solver (``ordered.nested_kernels``), where surfaces are rough but nearly smooth.
4. The plain active set (``active_set_kernels``), for all other contacts.

With a hardness, f is the curve of a contact whose pressures are bounded by it. Tables end where the first element
yields, and nothing is filtered. A solution of one of the solvers holds if no pressure in it is above the hardness; else
``yielding_kernels`` goes on from it.

Indices. Wheel 0 is wheel 1 and wheel 1 is wheel 2. ``tread_index`` and ``rail_index`` are the positions of tread and
rail at the middle of the area, in steps. They rise with time, may have any size, and are taken modulo the lengths of
treads and rails. An element ahead in x meets tread and rail at a higher index.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import inner_kernel, kernel
from .active_set_kernels import CONVERGED, solve_active_set
from .ordered.hinge_kernels import Hinges
from .ordered.nested_kernels import solve_in_order
from .ordered.order_kernels import FAR, NestedContacts, gaps_in_order
from .yielding_kernels import exceeds, solve_yielding

UNTABLED = -1
"""Instead of the number of a force table: there is none, filter or solve."""
SOLVED = -2
"""The same where only smooth surfaces have a table: solve."""


class ContactLaw(NamedTuple):
    """Both contacts, as plain arrays for compiled code; made by ``build_contact_law``."""

    tread: Real
    """Heights of the treads, (2, n_c, ny), m, negative where material is missing."""
    rail_row: NDArray[np.int32]
    """Row of ``rail`` at each rail position, (2, n_r); 0 where the rail is smooth."""
    rail: Real
    """Heights across the rails, (rows, ny), m; the first row is zero."""
    tread_mirrored: NDArray[np.bool_]
    """Whether tread and nominal surfaces within the area are symmetric about its middle, (2, n_c)."""
    rail_mirrored: NDArray[np.bool_]
    """Whether the rail is symmetric about the middle of the area, (2,)."""
    x: Real
    """Longitudinal positions of the elements, (nx,), m."""
    y: Real
    """Lateral positions of the elements, from the middle of each rail's head, (2, ny), m."""
    separation: Real
    """Separation of the nominal surfaces, (2, nx, ny), m."""
    influence: Real
    """Influence coefficients by element offset, (nx, ny), m/Pa."""
    element_area: float
    """dx dy, m^2."""
    hardness: float
    """Largest pressure, Pa; infinite for an elastic contact."""
    table: NDArray[np.int32]
    """Force table of each tread position on a smooth rail, (2, n_c), or UNTABLED, or SOLVED."""
    smooth_tables: int
    """The first so many tables are of smooth treads."""
    rail_table: NDArray[np.int32]
    """Force table of each rail position under a smooth tread, (2, n_r), likewise; 0 is a smooth rail."""
    first_point: NDArray[np.int64]
    """Where each force table starts in ``points``, and where the last ends, (tables + 1,)."""
    points: Real
    """Kinks of the force-approach curves, (points, 2): m, N."""
    tread_top: Real
    """Highest of the tread within the area, (2, n_c), m."""
    rail_top: Real
    """Highest of the rail within the area, (2, n_r), m."""
    nested: tuple[NestedContacts, NestedContacts]
    """Elements of each wheel in the order of the nested solver."""
    hinges: Hinges
    """The contact filter; without elements where contacts are not filtered."""
    largest_estimate: float
    """Largest estimate of the error of a filtered force, N."""
    in_contact: NDArray[np.bool_]
    """Elements in contact at the last solution, (2, nx, ny): the first guess of the next."""


@kernel
def total_separation(law: ContactLaw, wheel: int, tread_index: int, rail_index: int) -> Real:
    """Separation z_R + z_W + r_R + r_W of Eq. (12), (nx, ny), m.

    r is minus the height of a surface: missing material widens the gap.
    """
    nx, ny = law.separation.shape[1:]
    n_c, n_r = law.tread.shape[1], law.rail_row.shape[1]
    gap = np.empty((nx, ny))
    for i in range(nx):
        tread = law.tread[wheel, (tread_index + i - nx // 2) % n_c]
        rail = law.rail[law.rail_row[wheel, (rail_index + i - nx // 2) % n_r]]
        for j in range(ny):
            gap[i, j] = law.separation[wheel, i, j] - (tread[j] + rail[j])
    return gap


@kernel
def solve_nested(
    law: ContactLaw,
    wheel: int,
    tread_index: int,
    rail_index: int,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Solve a contact with ``solve_in_order``; parameters and returns are those of ``solve_contact``.

    With a status of FAR the contact is not for this method, and ``in_contact`` and ``pressure`` are unchanged.
    """
    nested, tread, rows = law.nested[wheel], law.tread[wheel], law.rail_row[wheel]
    if not np.isfinite(approach) or not compliance >= 0.0:
        return np.nan, np.nan, FAR
    top = law.tread_top[wheel, tread_index % len(tread)] + law.rail_top[wheel, rail_index % len(rows)]
    gap = np.empty(len(nested.element))
    shape = law.separation.shape[1:]
    m = gaps_in_order(nested, shape, tread, rows, law.rail, tread_index, rail_index, top, approach, gap)
    if m == FAR:
        return np.nan, np.nan, FAR
    guess, p, area = np.empty(m, np.bool_), np.empty(m), in_contact.reshape(-1)
    for c in range(m):
        guess[c] = area[nested.element[c]]
    force, stiffness, status = solve_in_order(nested, gap[:m], law.element_area, approach, compliance, guess, p)
    if status != FAR:
        for element in range(len(area)):
            area[element] = False
        for c in range(m):
            if guess[c]:
                area[nested.element[c]] = True
        if pressure.size:
            pressures = pressure.reshape(-1)
            for element in range(len(area)):
                pressures[element] = 0.0
            for c in range(m):
                if guess[c]:
                    pressures[nested.element[c]] = max(p[c], 0.0)
    return force, stiffness, status


@kernel
def solve_contact(
    law: ContactLaw,
    wheel: int,
    tread_index: int,
    rail_index: int,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Solve the elastic contact of a wheel at a position of tread and rail.

    The nested solver is tried first: it takes a twentieth of the time of the plain active set.

    Parameters
    ----------
    law
        Both contacts.
    wheel
        0 or 1.
    tread_index, rail_index
        Positions at the middle of the area, in steps.
    approach, compliance
        delta, m, and c0, m/N.
    in_contact
        First guess, (nx, ny); left with the solution, or all False without one.
    pressure
        Filled, (nx, ny), Pa; pass an empty (0, 0) array if you need the force alone.

    Returns
    -------
    force, stiffness, status
        F, N, dF/d delta, N/m, and the status of ``solve_active_set``.
    """
    force, stiffness, status = solve_nested(
        law, wheel, tread_index, rail_index, approach, compliance, in_contact, pressure
    )
    if status != FAR:
        return force, stiffness, status
    mirrored = law.tread_mirrored[wheel, tread_index % law.tread.shape[1]] and law.rail_mirrored[wheel]
    gap = total_separation(law, wheel, tread_index, rail_index)
    return solve_active_set(gap, mirrored, law.influence, law.element_area, approach, compliance, in_contact, pressure)


@kernel
def solve_bounded(
    law: ContactLaw,
    wheel: int,
    tread_index: int,
    rail_index: int,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Solve a contact with pressures up to the hardness; parameters and returns are those of ``solve_contact``.

    A function of its own: the elastic contact is compiled, to the last bit, as if there were none with a hardness.
    """
    p = pressure if pressure.size else np.empty(in_contact.shape)
    force, stiffness, status = solve_contact(law, wheel, tread_index, rail_index, approach, compliance, in_contact, p)
    if status != CONVERGED or not exceeds(p, law.hardness):
        return force, stiffness, status
    mirrored = law.tread_mirrored[wheel, tread_index % law.tread.shape[1]] and law.rail_mirrored[wheel]
    gap = total_separation(law, wheel, tread_index, rail_index)
    return solve_yielding(
        gap, mirrored, law.influence, law.element_area, approach, compliance, law.hardness, in_contact, p
    )


@inner_kernel
def table_force(points: Real, first: int, end: int, approach: float, compliance: float) -> float:
    """Force, N, from a table; 0 up to first touch, NaN beyond the last kink.

    Parameters
    ----------
    points, first, end
        Kinks of the curve are ``points[first:end]``: approach, m, and force, N.
    approach, compliance
        delta, m, and c0, m/N.
    """
    if approach <= points[first, 0]:
        return 0.0
    low, high = first, end - 1
    if not approach <= points[high, 0] + compliance * points[high, 1]:
        return np.nan
    while high - low > 1:
        middle = (low + high) // 2
        if points[middle, 0] + compliance * points[middle, 1] <= approach:
            low = middle
        else:
            high = middle
    slope = (points[high, 1] - points[low, 1]) / (points[high, 0] - points[low, 0])
    force: float = (points[low, 1] + slope * (approach - points[low, 0])) / (1.0 + compliance * slope)
    return force


@inner_kernel
def table_number(law: ContactLaw, wheel: int, tread_index: int, rail_index: int) -> np.int32:
    """Force table of these positions, both within the lengths of treads and rails; below 0 for none."""
    number: np.int32
    number, of_rail = law.table[wheel, tread_index], law.rail_table[wheel, rail_index]
    if of_rail != 0:
        number = of_rail if 0 <= number < law.smooth_tables else np.int32(UNTABLED)
    return number


@inner_kernel
def tabulated_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """Look ``contact_force`` up in a table; NaN where there is none, or where the force is beyond it.

    Both indices must be within the lengths of treads and rails. There are tables for each place of a tread on a smooth
    rail, and of a rail under a smooth tread; not where both have an irregularity, or where one is rough.
    """
    number = table_number(law, wheel, tread_index, rail_index)
    if number < 0:
        return np.nan
    return table_force(law.points, law.first_point[number], law.first_point[number + 1], approach, compliance)


@kernel
def solved_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """Solve for ``contact_force``, with the last solution in ``law.in_contact`` as the first guess."""
    in_contact, none = law.in_contact[wheel], np.empty((0, 0))
    if law.hardness < np.inf:
        return solve_bounded(law, wheel, tread_index, rail_index, approach, compliance, in_contact, none)[0]
    return solve_contact(law, wheel, tread_index, rail_index, approach, compliance, in_contact, none)[0]


@kernel
def contact_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """Contact force F = f(approach - compliance F), N, at least 0; NaN if it cannot be solved.

    The coupled step calls both parts of this function itself: a table is looked up three times as fast where the
    compiler need not pass the whole law to a function.

    Parameters
    ----------
    law
        Both contacts; ``law.in_contact`` is changed where the contact is solved.
    wheel
        0 or 1.
    tread_index, rail_index
        Positions at the middle of the area, in steps, of any size.
    approach
        -(xi_R + xi_W) of Eq. (12): the overlap of the nominal surfaces at the middle of the area, m.
    compliance
        c0, m/N.
    """
    tread, rail = tread_index % law.table.shape[1], rail_index % law.rail_table.shape[1]
    force = tabulated_force(law, wheel, tread, rail, approach, compliance)
    if np.isnan(force):
        force = solved_force(law, wheel, tread_index, rail_index, approach, compliance)
    return force
