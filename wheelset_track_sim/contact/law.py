"""Builds the contact law of the coupled step, and asks it for single solutions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from ..errors import ContactError, InputError
from ..irregularities import Irregularity, RailHeights, rail_heights, tread_heights
from ..irregularities.surface import RAILS, WHEELS, both_rails
from ..jit import Address
from .active_set_kernels import AT_BORDER, CONVERGED, NOT_CONVERGED
from .geometry import ContactGeometry
from .hertz import HertzContact
from .influence import influence_table
from .law_kernels import ContactLaw, contact_force, solve_contact, total_separation
from .nested import nested_contacts, no_nested_contacts
from .order_kernels import NestedContacts
from .tables import Progress, force_tables
from .windows import windows

REASONS = {
    NOT_CONVERGED: "the active set does not settle",
    AT_BORDER: "the contact reaches the border of the potential contact area",
}

ELEMENT_WIDTH = 0.75e-3
"""Width of the elements across the track, m: with 1 mm along it the force is within 0.2 % of Hertz from 20 kN on, where
the patch is 8 by 6 mm; with a width of 1 mm it is not."""


MOST_STEPS = 200
"""Of the search for the approach that bears a force, which takes about ten."""
TABLE_FORCE = 400e3
"""Largest force in the tables, N, beyond that of most impacts: the work of a table grows with the square of it."""


@dataclass(frozen=True, eq=False)
class ContactPatch:
    """Solution of one normal contact."""

    force: float
    """N."""
    stiffness: float
    """Derivative of the force by the approach, N/m."""
    approach: float
    """m."""
    pressure: NDArray[np.float64]
    """(nx, ny), Pa."""
    x: NDArray[np.float64]
    """Longitudinal positions of the elements, (nx,), m, ahead positive."""
    y: NDArray[np.float64]
    """Lateral positions of the elements, from the middle of the rail's head, (ny,), m, to the left positive."""


def contact_grid(
    geometry: ContactGeometry, dx: float, dy: float, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions x and y of the elements whose nominal separation is below ``reach``, m, and of one row more around.

    They count from where wheel and rail touch. With half-spaces the contact lies where the undeformed bodies would
    overlap, so this holds every contact of an approach up to ``reach``, under both wheels. Odd in number, with an
    element in the middle; not beside both rail heads. Raises InputError if the points of a profile end within.
    """
    half_y, radius = 0, geometry.wheel_radius
    for name, pair in zip(WHEELS, geometry.pairs, strict=True):
        if not reach <= pair.open_gap:
            raise InputError(
                f"the points of {name} or its rail end where the surfaces are {pair.open_gap:.3g} m apart, within the "
                f"potential contact area of {reach:.3g} m: give points further out"
            )
        for side, end in zip((-1, 1), pair.span, strict=True):
            y = np.arange(int(side * (end - pair.touch) / dy * (1 + 1e-12)) + 1) * dy
            within = np.flatnonzero(pair.gap(pair.touch + side * y) < reach)
            half_y = max(half_y, min(int(within[-1]) + 1, len(y) - 1))
            radius = max(radius, geometry.wheel_radius + pair.wheel_height(pair.touch + side * y[within]).max())
    half_x = int(np.sqrt(reach * (2 * radius - reach)) / dx) + 1
    return _spaced(half_x, dx), _spaced(half_y, dy)


def build_contact_law(
    irregularities: Sequence[Irregularity],
    geometry: ContactGeometry,
    dx: float,
    n_c: int,
    *,
    rail_steps: int = 1,
    dy: float = ELEMENT_WIDTH,
    largest_force: float = 600e3,
    tables: bool | Literal["smooth"] = True,
    progress: Progress | None = None,
) -> ContactLaw:
    """Contact law of both wheels on elements dx x dy (m), with ``n_c`` steps of dx around the wheels.

    ``irregularities`` are those of treads and of rails, which repeat after ``rail_steps`` steps.
    The area holds every contact up to ``largest_force``, N. ``tables`` says whether the force-approach curves up to
    ``TABLE_FORCE`` are worked out beforehand, for every position on treads and rails at which an irregularity can bear;
    without them, above that force, where tread and rail both have an irregularity, and where one is rough, the active
    set is solved in every step. With ``"smooth"`` only the smooth tread has its curve: for few passages of a defect
    that is the fastest. ``progress`` is told the share done.
    Raises InputError for a grid that makes no sense and for what the irregularities refuse.
    """
    for name, value, low, high in (
        ("dx", dx, 1e-4, 5e-3),
        ("dy", dy, 1e-4, 5e-3),
        ("largest_force", largest_force, 1e3, 2e6),
    ):
        if not low <= value <= high:
            raise InputError(f"{name} = {value:g} is out of range: give a value from {low:g} to {high:g} (SI units)")
    if not rail_steps >= 1:
        raise InputError(f"rail_steps = {rail_steps} is out of range: give at least 1 step")
    if not n_c >= 100:
        raise InputError(f"n_c = {n_c} is out of range: give at least 100 steps around the wheel")

    # All of the tread that can ever bear lies on the rail head; how much of it depends on the depth of the damage.
    ends = [abs(end - pair.touch) for pair in geometry.pairs for end in pair.span]
    head = int(max(ends) / dy * (1 + 1e-12))
    wide = _spaced(head, dy)
    touch, circle = (np.array([each(wheel) for wheel in (0, 1)]) for each in (geometry.touch, geometry.rolling_circle))
    treads = [
        tread_heights(irregularities, name, n_c, dx, wide + at) for name, at in zip(WHEELS, touch - circle, strict=True)
    ]
    rails = [
        rail_heights(irregularities, name, rail_steps, dx, wide + at) for name, at in zip(RAILS, touch, strict=True)
    ]
    # A crown of the smaller radius needs a larger approach for the same force.
    sharper = HertzContact(
        geometry.wheel_radius, min(pair.sharpest for pair in geometry.pairs), geometry.contact_modulus
    )
    smooth_reach = sharper.approach(largest_force)
    x, y = _area(geometry, dx, dy, smooth_reach, treads, rails)
    if len(x) > n_c:
        raise InputError(f"n_c = {n_c} is less than the {len(x)} elements of the contact area: give more steps")
    nx, ny = len(x), len(y)
    shown = slice(head - ny // 2, head + ny // 2 + 1)
    tread = np.stack([heights[:, shown] for heights in treads])
    rail_row, rail = both_rails([RailHeights(row, heights[:, shown]) for row, heights in rails])
    places = touch[:, None] + y
    separation = np.stack([geometry.separation(wheel, x[:, None], places[wheel]) for wheel in (0, 1)])
    symmetric = (separation == separation[:, :, ::-1]).all(axis=(1, 2))
    influence = influence_table(nx, ny, dx, dy, geometry.youngs_modulus, geometry.poissons_ratio)

    table, rail_table, smooth = np.full((2, n_c), -1, np.int32), np.full(rail_row.shape, -1, np.int32), 0
    first, points = np.zeros(1, np.int64), np.zeros((0, 2))
    if tables:
        table_force = min(largest_force, TABLE_FORCE)
        placed = windows(tread, rail_row, rail, separation, sharper.approach(table_force))
        gaps, table, rail_table, smooth = placed
        if tables == "smooth":
            gaps = gaps[:smooth]
            table, rail_table = (np.where(each >= smooth, np.int32(-1), each) for each in (table, rail_table))
        stored = force_tables(gaps, influence, dx * dy, table_force, progress)
        first, points = stored.first, stored.points
    return ContactLaw(
        tread=tread,
        rail_row=rail_row,
        rail=rail,
        tread_mirrored=_mirrored_within(tread, nx) & symmetric[:, None],
        rail_mirrored=(rail == rail[:, ::-1]).all(axis=1)[rail_row].all(axis=1),
        x=x,
        y=places,
        separation=separation,
        influence=influence,
        element_area=dx * dy,
        table=table,
        smooth_tables=smooth,
        rail_table=rail_table,
        first_point=first,
        points=points,
        tread_top=_highest_within(tread.max(axis=2), nx),
        rail_top=_highest_within(rail.max(axis=1)[rail_row], nx),
        nested=_nested(geometry, x, y, separation)
        if _solves(table, rail_table, smooth)
        else (no_nested_contacts(),) * 2,
        in_contact=np.zeros((2, nx, ny), np.bool_),
    )


def _area(
    geometry: ContactGeometry,
    dx: float,
    dy: float,
    smooth_reach: float,
    treads: Sequence[NDArray[np.float64]],
    rails: Sequence[RailHeights],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Elements x and y of the potential contact area, m.

    Where all heights within the area lie between ``low`` and ``high``, a force needs at most the approach of a smooth
    contact that lies at ``low``; so all elements in contact have a nominal separation of up to ``smooth_reach`` and
    high - low. What long waves raise and lower as a whole does not count.
    """
    on_treads = [(heights.max(axis=1), heights.min(axis=1)) for heights in treads]
    on_rails = [(heights.max(axis=1)[row], heights.min(axis=1)[row]) for row, heights in rails]
    reach, needed = 0.0, smooth_reach
    while needed > reach:
        reach = needed
        x, y = contact_grid(geometry, dx, dy, reach)
        needed = smooth_reach + sum(
            max(_difference_within(high, low, len(x)) for high, low in pair) for pair in (on_treads, on_rails)
        )
    return x, y


def _difference_within(high: NDArray[np.float64], low: NDArray[np.float64], nx: int) -> float:
    """Largest difference, m, of the highest and the lowest within nx steps of a surface, both (steps,), m."""
    nx = min(nx, len(high))
    return float((maximum_filter1d(high, nx, mode="wrap") - minimum_filter1d(low, nx, mode="wrap")).max())


def _solves(table: NDArray[np.int32], rail_table: NDArray[np.int32], smooth: int) -> bool:
    """Whether tables leave places to the solver."""
    without = (table < 0).any() or (rail_table < 0).any()
    return bool(without or ((table >= smooth).any(axis=1) & rail_table.any(axis=1)).any())


def _nested(
    geometry: ContactGeometry, x: NDArray[np.float64], y: NDArray[np.float64], separation: NDArray[np.float64]
) -> tuple[NestedContacts, NestedContacts]:
    first = nested_contacts(geometry, 0, x, y, separation[0])
    alike = (separation[0] == separation[1]).all()
    return first, first if alike else nested_contacts(geometry, 1, x, y, separation[1])


def _spaced(half: int, step: float) -> NDArray[np.float64]:
    return np.arange(-half, half + 1, dtype=np.float64) * step


def _highest_within(top: NDArray[np.float64], nx: int) -> NDArray[np.float64]:
    """Highest within nx // 2 of each of (2, n) heights, m."""
    return np.asarray(maximum_filter1d(top, min(nx, 2 * top.shape[1] - 1), axis=1, mode="wrap"))


def _mirrored_within(tread: NDArray[np.float64], nx: int) -> NDArray[np.bool_]:
    """Whether all rows within nx // 2 of each row are symmetric about the middle, (2, n_c)."""
    skew = (tread != tread[:, :, ::-1]).any(axis=2)
    near: NDArray[np.bool_] = np.zeros_like(skew)
    for offset in range(-(nx // 2), nx // 2 + 1):
        near |= np.roll(skew, offset, axis=1)
    return np.logical_not(near)


def solve_patch(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float = 0.0
) -> ContactPatch:
    """Contact of ``wheel`` (0 or 1) solved for pressure, force and stiffness; leaves the state of ``law`` as it is.

    Arguments as in ``contact_force``. Raises ContactError with the inputs if there is no solution.
    """
    pressure = np.empty(law.separation.shape[1:])
    guess = np.zeros(law.separation.shape[1:], np.bool_)
    force, stiffness, status = solve_contact(
        law, wheel, tread_index, rail_index, float(approach), float(compliance), guess, pressure
    )
    if status != CONVERGED:
        raise ContactError(
            f"contact of {WHEELS[wheel]} at tread step {tread_index}, rail step {rail_index}, approach {approach:g} m, "
            f"compliance {compliance:g} m/N: {REASONS.get(status, 'the inputs are not finite')}"
        )
    return ContactPatch(force, stiffness, float(approach), pressure, law.x, law.y[wheel])


_SOLVER: list[Address] = []


def solver(law: ContactLaw) -> Address:
    """``solve_contact`` for the coupled step; compiled when that is called, which takes half a minute, once."""
    if not _SOLVER:  # to the compiler, all laws are of one type
        call = (law, 0, 0, 0, 0.0, 0.0, law.in_contact[0], np.empty((0, 0)))
        _SOLVER.append(Address(solve_contact, (0.0, 0.0, 0), call))
    return _SOLVER[0]


def force_at(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, approach: float, compliance: float = 0.0
) -> float:
    """``contact_force`` that raises ContactError, with the inputs, where that returns NaN."""
    force = contact_force(law, wheel, tread_index, rail_index, float(approach), float(compliance))
    if not np.isfinite(force):
        force = solve_patch(law, wheel, tread_index, rail_index, approach, compliance).force
    return float(force)


def approach_for_force(
    law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float, compliance: float = 0.0
) -> float:
    """Approach, m, at which the contact of ``wheel`` bears ``force``, N: the inverse of ``contact_force``.

    Zero force gives the approach of first touch. Raises InputError for a negative force and ContactError for one that
    the law cannot bear.
    """
    if not 0.0 <= force < np.inf:
        raise InputError(f"force = {force:g} N is out of range: give a force that presses, from 0 N")
    number = law.table[wheel, tread_index % law.table.shape[1]]
    on_rail = law.rail_table[wheel, rail_index % law.rail_table.shape[1]]
    if on_rail != 0:
        number = on_rail if 0 <= number < law.smooth_tables else -1
    if number >= 0:
        curve = law.points[law.first_point[number] : law.first_point[number + 1]]
        if force <= curve[-1, 1]:
            return float(np.interp(force, curve[:, 1], curve[:, 0])) + compliance * force
    touch = float(np.min(total_separation(law, wheel, tread_index, rail_index)))
    if force == 0.0:
        return touch
    approach = touch + 1e-6
    low, high = touch, np.inf
    for _ in range(MOST_STEPS):
        if np.isfinite(high) and high - low <= 1e-2 * (high - touch):
            break
        try:
            patch = solve_patch(law, wheel, tread_index, rail_index, approach)
        except ContactError:
            # Too deep for the area: come back half of the way.
            high = approach
            approach = 0.5 * (low + high)
            continue
        if patch.force < force:
            low = approach
        # The force is convex in the approach and made of straight pieces: Newton's method ends exactly, from above
        # without a step too far. From far below it is taken on the power 2/3, which is nearly straight (Hertz).
        step = (force - patch.force) / patch.stiffness
        if force > 2.0 * patch.force:
            step = 1.5 * ((force / patch.force) ** (2 / 3) - 1.0) * patch.force / patch.stiffness
        if abs(step) <= 2 * np.spacing(max(abs(approach), abs(touch), approach - touch)):  # it may be next to zero
            return approach + compliance * force
        approach = approach + step if approach + step < high else 0.5 * (approach + high)
    raise ContactError(
        f"contact of {WHEELS[wheel]} at tread step {tread_index}, rail step {rail_index} does not bear {force:g} N"
    )
