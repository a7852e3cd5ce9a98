"""The contact law of the coupled step: approach in, force out, for both wheels.

Indices: wheel 0 is wheel 1 and wheel 1 is wheel 2. ``tread_index`` and ``rail_index`` are those of the middle of the
area; they count in steps, rise with time, may be of any size and are taken modulo the lengths of treads and rails. An
element ahead in x meets tread and rail at a higher index.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import inner_kernel, kernel
from .active_set_kernels import solve_active_set
from .ordered.nested_kernels import solve_in_order
from .ordered.order_kernels import FAR, NestedContacts, gaps_in_order


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
    table: NDArray[np.int32]
    """Force table of each tread position on a smooth rail, (2, n_c); -1 to solve."""
    smooth_tables: int
    """The first so many tables are of smooth treads."""
    rail_table: NDArray[np.int32]
    """Force table of each rail position under a smooth tread, (2, n_r); 0 is a smooth rail, -1 to solve."""
    first_point: NDArray[np.int64]
    """Where each force table starts in ``points``, and where the last ends, (tables + 1,)."""
    points: Real
    """Kinks of the force-approach curves, (points, 2): m, N."""
    tread_top: Real
    """Highest of the tread within the area, (2, n_c), m."""
    rail_top: Real
    """Highest of the rail within the area, (2, n_r), m."""
    nested: tuple[NestedContacts, NestedContacts]
    """What solves contacts of each wheel that are nearly those of smooth surfaces."""
    in_contact: NDArray[np.bool_]
    """Elements in contact at the last solution, (2, nx, ny): the first guess of the next."""


@kernel
def total_separation(law: ContactLaw, wheel: int, tread_index: int, rail_index: int) -> Real:
    """z_R + z_W + r_R + r_W of Eq. (12), (nx, ny), m; r is minus the height: missing material widens the gap."""
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
    """``solve_contact`` by ``solve_in_order``; with a status of FAR, that is not for it and nothing has changed."""
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
    """Force, N, stiffness, N/m, and status of ``solve_active_set`` at a position of tread and rail.

    Contacts that are nearly those of smooth surfaces are solved in their order, in a twentieth of the time.
    """
    force, stiffness, status = solve_nested(
        law, wheel, tread_index, rail_index, approach, compliance, in_contact, pressure
    )
    if status != FAR:
        return force, stiffness, status
    mirrored = law.tread_mirrored[wheel, tread_index % law.tread.shape[1]] and law.rail_mirrored[wheel]
    gap = total_separation(law, wheel, tread_index, rail_index)
    return solve_active_set(gap, mirrored, law.influence, law.element_area, approach, compliance, in_contact, pressure)


@inner_kernel
def table_force(points: Real, first: int, end: int, approach: float, compliance: float) -> float:
    """Force, N, from the kinks ``points[first:end]`` at an approach, m, of which ``compliance`` times force is lost.

    F = f(approach - c0 F) has one solution, on the segment where approach - c0 F falls; NaN beyond the last kink.
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
def tabulated_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """``contact_force`` from a table; NaN where there is none or the force is beyond it.

    Indices are below the lengths of treads and rails. There is a table for each place of a smooth surface under what is
    on the other; where both have something, or one is rough, there is none.
    """
    number, of_rail = law.table[wheel, tread_index], law.rail_table[wheel, rail_index]
    if of_rail != 0:
        number = of_rail if 0 <= number < law.smooth_tables else np.int32(-1)
    if number < 0:
        return np.nan
    return table_force(law.points, law.first_point[number], law.first_point[number + 1], approach, compliance)


@kernel
def solved_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """``contact_force`` from the active set, whose last solution in ``law.in_contact`` is the first guess."""
    return solve_contact(
        law, wheel, tread_index, rail_index, approach, compliance, law.in_contact[wheel], np.empty((0, 0))
    )[0]


@kernel
def contact_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float
) -> float:
    """Contact force, N, >= 0, where F = f(approach - compliance F); NaN if it cannot be solved.

    ``approach`` (m) is xi_r + xi_w of Eq. (12) with its sign turned: the overlap of the nominal surfaces at the
    middle of the area. ``compliance`` is in m/N. The two parts may also be called one after the other: tables are
    looked up three times as fast where the compiler need not pass the whole law to a function.
    """
    tread, rail = tread_index % law.table.shape[1], rail_index % law.rail_table.shape[1]
    force = tabulated_force(law, wheel, tread, rail, approach, compliance)
    if np.isnan(force):
        force = solved_force(law, wheel, tread_index, rail_index, approach, compliance)
    return force
