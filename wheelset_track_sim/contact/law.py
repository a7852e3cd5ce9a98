"""Builds the contact law of the coupled step."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from ..errors import InputError
from ..irregularities import Irregularity, RailHeights, rail_heights, tread_heights
from ..irregularities.surface import RAILS, WHEELS, both_rails
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from .geometry import ContactGeometry
from .hertz import HertzContact
from .influence import influence_table
from .law_kernels import SOLVED, UNTABLED, ContactLaw
from .ordered.hinge_kernels import Hinges
from .ordered.nested import hinges_of, nested_contacts, no_hinges, no_nested_contacts
from .ordered.order_kernels import NestedContacts
from .potential_area import evenly_spaced, potential_contact_area
from .tables import force_tables
from .windows import windows

ELEMENT_WIDTH = 0.75e-3
"""Width of the elements across the track, m: with 1 mm along it the force is within 0.2 % of Hertz from 20 kN on, where
the patch is 8 by 6 mm; with a width of 1 mm it is not."""

TABLE_FORCE = 400e3
"""Largest force in the tables, N, beyond that of most impacts: the work of a table grows with the square of it."""


class RollingSurfaces(NamedTuple):
    """Treads and rails that roll on each other, and where they can touch."""

    x: Real
    """Elements of the potential contact area along the track, (nx,), m, from below the axle."""
    y: Real
    """Elements across, (ny,), m, from where wheel and rail touch."""
    treads: tuple[Real, Real]
    """Heights of each tread over the rail's head, (n_c, m), m."""
    rails: tuple[RailHeights, RailHeights]
    sharper: HertzContact
    """A smooth contact that needs a larger approach than these for the same force."""


def rolling_surfaces(
    irregularities: tuple[Irregularity, ...],
    geometry: ContactGeometry,
    dx: float,
    n_c: int,
    rail_steps: int,
    dy: float = ELEMENT_WIDTH,
    largest_force: float = 600e3,
) -> RollingSurfaces:
    """Heights of both treads and rails, and the potential contact area; arguments as of ``build_contact_law``.

    A scenario is checked with it, and its contact law is built from it: the latest two are kept.

    Raises
    ------
    InputError
        For a grid that makes no sense, for what the irregularities refuse, and for points of a profile that end within
        the potential contact area.
    """
    return _rolling_surfaces(irregularities, geometry, dx, n_c, rail_steps, dy, largest_force)


@lru_cache(maxsize=2)
def _rolling_surfaces(
    irregularities: tuple[Irregularity, ...],
    geometry: ContactGeometry,
    dx: float,
    n_c: int,
    rail_steps: int,
    dy: float,
    largest_force: float,
) -> RollingSurfaces:
    _check(dx, dy, largest_force, rail_steps, n_c)
    # All of the tread that can ever bear lies on the rail head; how much of it depends on the depth of the damage.
    ends = [abs(end - pair.touch) for pair in geometry.pairs for end in pair.span]
    wide = evenly_spaced(int(max(ends) / dy * (1 + 1e-12)), dy)
    touch, circle = (np.array([each(wheel) for wheel in (0, 1)]) for each in (geometry.touch, geometry.rolling_circle))
    treads = [
        tread_heights(irregularities, name, n_c, dx, wide + at) for name, at in zip(WHEELS, touch - circle, strict=True)
    ]
    rails = [
        _rail_heights(
            tuple(each for each in irregularities if each.on == name), name, rail_steps, dx, tuple((wide + at).tolist())
        )
        for name, at in zip(RAILS, touch, strict=True)
    ]
    # A crown of the smaller radius needs a larger approach for the same force.
    sharper = HertzContact(
        geometry.wheel_radius, min(pair.sharpest for pair in geometry.pairs), geometry.contact_modulus
    )
    x, y = potential_contact_area(geometry, dx, dy, sharper.approach(largest_force), treads, rails)
    if len(x) > n_c:
        raise InputError(f"n_c = {n_c} is less than the {len(x)} elements of the contact area: give more steps")
    return RollingSurfaces(x, y, (treads[0], treads[1]), (rails[0], rails[1]), sharper)


@lru_cache(maxsize=2)
def _rail_heights(
    irregularities: tuple[Irregularity, ...], rail: str, steps: int, dx: float, y: tuple[float, ...]
) -> RailHeights:
    """Heights of a rail, as of ``rail_heights``: kept, for they take long, and mostly the treads alone change."""
    return rail_heights(irregularities, rail, steps, dx, np.array(y))


def build_contact_law(
    irregularities: Sequence[Irregularity],
    geometry: ContactGeometry,
    dx: float,
    n_c: int,
    *,
    rail_steps: int = 1,
    dy: float = ELEMENT_WIDTH,
    largest_force: float = 600e3,
    hardness: float = np.inf,
    tables: bool | Literal["smooth"] = True,
    smooth: ContactLaw | None = None,
    filtered: bool = False,
    progress: Progress | None = None,
) -> ContactLaw:
    """Contact law of both wheels on elements dx x dy (m), with ``n_c`` steps of dx around the wheels.

    ``irregularities`` are those of treads and of rails, which repeat after ``rail_steps`` steps.
    The area holds every contact up to ``largest_force``, N. No pressure is above ``hardness``, Pa.
    ``tables`` says whether the force-approach curves up to ``TABLE_FORCE`` are worked out beforehand, for every
    position on treads and rails at which an irregularity can bear. Without them, above that force, where an element
    yields, where tread and rail both have an irregularity, and where one is rough, the active set is solved in every
    step. With ``"smooth"`` only the smooth tread has its curve: for few passages of a defect that is the fastest. The
    curve is that of the law of ``smooth`` surfaces if it is given.
    With ``filtered`` and tables, contacts that have none in any case may be filtered; the law's ``largest_estimate``
    says which.
    Raises InputError for a grid that makes no sense and for what the irregularities refuse.
    """
    surfaces = rolling_surfaces(tuple(irregularities), geometry, dx, n_c, rail_steps, dy, largest_force)
    return law_of_surfaces(
        surfaces,
        geometry,
        dx,
        dy=dy,
        table_force=min(largest_force, TABLE_FORCE),
        hardness=hardness,
        tables=tables,
        smooth=smooth,
        filtered=filtered,
        progress=progress,
    )


def law_of_surfaces(
    surfaces: RollingSurfaces,
    geometry: ContactGeometry,
    dx: float,
    *,
    dy: float = ELEMENT_WIDTH,
    table_force: float = TABLE_FORCE,
    hardness: float = np.inf,
    tables: bool | Literal["smooth"] = True,
    smooth: ContactLaw | None = None,
    filtered: bool = False,
    progress: Progress | None = None,
) -> ContactLaw:
    """Contact law of surfaces on elements dx x dy, m; other arguments as of ``build_contact_law``."""
    x, y, treads, rails, sharper = surfaces
    n_c = len(treads[0])
    nx, ny = len(x), len(y)
    head = treads[0].shape[1] // 2
    shown = slice(head - ny // 2, head + ny // 2 + 1)
    touch = np.array([geometry.touch(wheel) for wheel in (0, 1)])
    tread = np.stack([heights[:, shown] for heights in treads])
    rail_row, rail = both_rails([RailHeights(row, heights[:, shown]) for row, heights in rails])
    places = touch[:, None] + y
    separation = _separation(geometry, x, y)
    symmetric = (separation == separation[:, :, ::-1]).all(axis=(1, 2))
    influence = influence_table(nx, ny, dx, dy, geometry.youngs_modulus, geometry.poissons_ratio)

    table, rail_table, own = np.full((2, n_c), UNTABLED, np.int32), np.full(rail_row.shape, UNTABLED, np.int32), 0
    first, points = np.zeros(1, np.int64), np.zeros((0, 2))
    filtered = filtered and bool(tables) and hardness == np.inf
    if tables:
        gaps, table, rail_table, own = windows(tread, rail_row, rail, separation, sharper.approach(table_force))
        filtered &= _solves(table, rail_table, own)
        if tables == "smooth":
            gaps = gaps[:own]
            table, rail_table = (np.where(each >= own, SOLVED, each) for each in (table, rail_table))
        if tables == "smooth" and smooth is not None:
            first, points = smooth.first_point, smooth.points
        else:
            stored = force_tables(gaps, influence, dx * dy, table_force, hardness, progress)
            first, points = stored.first, stored.points
    solves = _solves(table, rail_table, own)
    nested = _nested(geometry, nx, ny, dx, dy) if solves else (no_nested_contacts(),) * 2
    hinges = _hinges(geometry, nx, ny, dx, dy) if filtered else no_hinges()
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
        hardness=float(hardness),
        table=table,
        smooth_tables=own,
        rail_table=rail_table,
        first_point=first,
        points=points,
        tread_top=_highest_within(tread.max(axis=2), nx),
        rail_top=_highest_within(rail.max(axis=1)[rail_row], nx),
        nested=nested,
        hinges=hinges,
        largest_estimate=0.0,
        in_contact=np.zeros((2, nx, ny), np.bool_),
    )


def _check(dx: float, dy: float, largest_force: float, rail_steps: int, n_c: int) -> None:
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


def _solves(table: NDArray[np.int32], rail_table: NDArray[np.int32], smooth: int) -> bool:
    """Whether tables leave places to the solver."""
    without = (table < 0).any() or (rail_table < 0).any()
    return bool(without or ((table >= smooth).any(axis=1) & rail_table.any(axis=1)).any())


def _separation(geometry: ContactGeometry, x: Real, y: Real) -> Real:
    """Separation of both nominal wheels and rails, (2, nx, ny), m, at ``x`` and ``y`` from where they touch, m."""
    return np.stack([geometry.separation(wheel, x[:, None], geometry.touch(wheel) + y) for wheel in (0, 1)])


@lru_cache(maxsize=4)
def _nested(geometry: ContactGeometry, nx: int, ny: int, dx: float, dy: float) -> tuple[NestedContacts, NestedContacts]:
    """Of both wheels; kept, for they are the same for all irregularities that need an area of that size."""
    x, y = evenly_spaced(nx // 2, dx), evenly_spaced(ny // 2, dy)
    separation = _separation(geometry, x, y)
    first = nested_contacts(geometry, 0, x, y, separation[0])
    alike = (separation[0] == separation[1]).all()
    return first, first if alike else nested_contacts(geometry, 1, x, y, separation[1])


@lru_cache(maxsize=4)
def _hinges(geometry: ContactGeometry, nx: int, ny: int, dx: float, dy: float) -> Hinges:
    """Hinges of the filter of these contacts; kept likewise."""
    nested = _nested(geometry, nx, ny, dx, dy)
    different = nested[:1] if nested[1] is nested[0] else nested
    along = dx * np.arange(-nx, nx + 1)
    fall = np.stack([geometry.separation(wheel, along, geometry.touch(wheel)) for wheel in range(len(different))])
    return hinges_of(different, fall, ny, geometry.contact_modulus, dx, dy)


def _highest_within(top: Real, nx: int) -> Real:
    """Highest within nx // 2 of each of (2, n) heights, m."""
    return np.asarray(maximum_filter1d(top, min(nx, 2 * top.shape[1] - 1), axis=1, mode="wrap"))


def _mirrored_within(tread: Real, nx: int) -> NDArray[np.bool_]:
    """Whether all rows within nx // 2 of each row are symmetric about the middle, (2, n_c)."""
    skew = (tread != tread[:, :, ::-1]).any(axis=2)
    near: NDArray[np.bool_] = maximum_filter1d(skew, nx, axis=1, mode="wrap")
    return np.logical_not(near)
