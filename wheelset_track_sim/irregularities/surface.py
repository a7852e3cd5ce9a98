"""Heights of treads and rails on the grid of steps, summed up from what irregularities say."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..inputs.schema import check
from ..runtime.arrays import Real

WHEELS = ("wheel_1", "wheel_2")
RAILS = ("rail_1", "rail_2")
DEEPEST = 0.020
"""Greatest depth of all irregularities together, m: the contact area, and with it the work, grows with it."""
LONGEST_IRREGULAR = 400_000
"""Steps of both rails together that may have a height: 100 to 200 MB. The line around them may be longer."""
LONGEST_LINE = 5000.0
"""Length after which rails repeat at most, m: 100 MB at steps of 1 mm."""
LINE = 60.0
"""Length after which rails repeat if nothing says otherwise, m, or as many times that as irregularities need."""


class Patch(NamedTuple):
    """Heights over some consecutive steps of a surface."""

    first: int
    """Step of the first row; any whole number, for surfaces repeat."""
    heights: Real
    """(steps, len(y)), m; or (steps, 1) if it is the same across."""


@dataclass(frozen=True)
class Surface:
    """A tread or a rail that repeats after ``steps`` of ``dx``, m."""

    name: str
    """``wheel_1``, ``wheel_2``, ``rail_1`` or ``rail_2``: rails are called after the wheel on them."""
    steps: int
    dx: float

    @property
    def length(self) -> float:
        """After which it repeats, m."""
        return self.steps * self.dx

    @property
    def radius(self) -> float:
        """Of a wheel, m."""
        return self.length / (2 * math.pi)

    def at_angle(self, angle: float) -> int:
        """Step nearest to an angle, rad."""
        return round(angle / (2 * math.pi) * self.steps)

    def at(self, position: float) -> int:
        """Step nearest to a position along it, m."""
        return round(position / self.dx)

    def around(self, centre: int, half_length: float, height: Callable[[Real], Real]) -> Patch:
        """Patch of a shape whose height is zero beyond ``half_length``, m, from its centre at a step.

        ``height`` takes distances from the centre, (steps, 1), m: a shape is sampled alike wherever it sits.
        """
        reach = math.ceil(half_length / self.dx - 1e-9)
        return Patch(centre - reach, height(np.arange(-reach, reach + 1, dtype=np.float64)[:, None] * self.dx))


class Irregularity(Protocol):
    """Deviation of a tread or a rail from its nominal surface: what a kind of irregularity has to have.

    A kind is a frozen dataclass. Its fields are the keys that people give in a scenario file; numbers declared with
    ``inputs.schema.quantity`` carry unit, limits and meaning, and ``check_shape`` in ``__post_init__`` checks them.
    Where irregularities lie over one another, their heights add up. Kinds of other packages are registered as
    ``irregularities.kinds`` says. A kind of a rail may have a property ``end``: the position where it ends, m.

    Examples
    --------
    A groove around the tread, 10 mm wide:

    >>> @dataclass(frozen=True)
    ... class Groove:
    ...     type: ClassVar[str] = "groove"
    ...     on: Literal["wheel_1", "wheel_2"]
    ...     depth: float = quantity("m", 0.0, 1e-3, "depth of the groove")
    ...
    ...     def patches(self, surface, y):
    ...         across = np.where(np.abs(y) < 0.005, -self.depth, 0.0)
    ...         yield Patch(0, np.tile(across, (surface.steps, 1)))
    """

    type: ClassVar[str]
    """Name of the kind in scenario files."""

    @property
    def on(self) -> str:
        """Name of the surface that has it: ``wheel_1``, ``wheel_2``, ``rail_1`` or ``rail_2``."""
        ...

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on a surface where they are not zero.

        Parameters
        ----------
        surface
            The tread or rail: its name, its number of steps, and their length ``dx``, m.
        y : (m,) array
            Lateral positions, m, positive to the left: from the rolling circle of a wheel, from the middle of a rail.

        Returns
        -------
        iterable of Patch
            First step and heights (steps, m) or (steps, 1), m, negative where material is missing. Patches add up.

        Raises
        ------
        InputError
            If it cannot be on a surface of that length and step.
        """
        ...


def check_shape(shape: Any, surfaces: Sequence[str]) -> None:
    """Raise InputError for an irregularity on none of the ``surfaces`` it can be on, or a number out of its limits."""
    if shape.on not in surfaces:
        kind = "wheel" if surfaces == WHEELS else "rail" if surfaces == RAILS else "surface"
        known = f"{', '.join(surfaces[:-1])} or {surfaces[-1]}"
        raise InputError(f"on = {shape.on!r} is not a known {kind}: give {known}")
    check(shape)


def tread_heights(
    irregularities: Iterable[Irregularity], wheel: str, rolling_circumference_steps: int, dx: float, y: Real
) -> Real:
    """Sum of the heights on ``wheel``, (steps around the circumference, len(y)), m, negative where material is missing.

    What is longer than the circumference, deeper than ``DEEPEST`` together with others, or not finite is refused:
    InputError.
    """
    surface = Surface(wheel, rolling_circumference_steps, dx)
    heights = np.zeros((surface.steps, len(y)))
    for patch in _patches(irregularities, surface, y):
        heights[(patch.first + np.arange(len(patch.heights))) % surface.steps] += patch.heights
    _check_heights(heights, surface)
    return heights


class RailHeights(NamedTuple):
    """Heights of a rail, stored once for all steps that have the same."""

    row: NDArray[np.int32]
    """Row of ``heights`` at each step, (steps,); 0 where the rail is smooth."""
    heights: Real
    """Different heights across the rail, (rows, len(y)), m; the first row is zero."""

    def all(self) -> Real:
        """(steps, len(y)), m."""
        return self.heights[self.row]

    def at(self, steps: NDArray[np.int64]) -> Real:
        """Heights at some steps, (len(steps), len(y)), m."""
        return self.heights[self.row[steps]]


def rail_heights(irregularities: Iterable[Irregularity], rail: str, steps: int, dx: float, y: Real) -> RailHeights:
    """Sum of the heights on ``rail``, which repeats after ``steps``, from position 0 on.

    Raises InputError as ``tread_heights`` does, and for more than half of LONGEST_IRREGULAR steps with a height.
    """
    surface = Surface(rail, steps, dx)
    patches = list(_patches(irregularities, surface, y))
    place = np.zeros(steps, np.int32)
    for patch in patches:
        place[(patch.first + np.arange(len(patch.heights))) % steps] = 1
    count = int(place.sum())
    if 2 * count > LONGEST_IRREGULAR:
        raise InputError(
            f"{rail} is irregular over {count * dx:g} m: give a line_length or a length of the irregularity "
            f"of {LONGEST_IRREGULAR // 2 * dx:g} m at most"
        )
    place = np.cumsum(place, dtype=np.int32) * place
    heights = np.zeros((1 + count, len(y)))
    for patch in patches:
        heights[place[(patch.first + np.arange(len(patch.heights))) % steps]] += patch.heights
    _check_heights(heights, surface)
    kept, number = distinct_rows(heights)
    return RailHeights(number[place], kept)


def both_rails(rails: Sequence[RailHeights]) -> tuple[NDArray[np.int32], Real]:
    """Rows of both rails in one array: the row of each at its steps, (2, steps), and the heights, (rows, len(y)), m."""
    first, second = rails
    behind = np.where(second.row > 0, second.row + np.int32(len(first.heights) - 1), np.int32(0))
    return np.stack([first.row, behind]), np.concatenate([first.heights, second.heights[1:]])


def distinct_rows(rows: Real) -> tuple[Real, NDArray[np.int32]]:
    """Rows that differ, in the order in which they come, and the number of each among them."""
    even = ~rows.any(axis=1)
    looked_at = np.flatnonzero(~even | (np.cumsum(even) == 1))  # of the rows without heights the first stands for all
    found: dict[bytes, int] = {}
    number = np.empty(len(rows), np.int32)
    number[looked_at] = [found.setdefault(row.tobytes(), len(found)) for row in rows[looked_at] + 0.0]  # no -0.0
    number[even] = number[even.argmax()]
    return rows[np.unique(number, return_index=True)[1]], number


def line_steps(irregularities: Iterable[Irregularity], line_length: float | None, dx: float) -> int:
    """Steps of ``dx``, m, after which the rails repeat: those of ``line_length``, m, or as many as are needed if None.

    One step is enough where both rails are smooth. Raises InputError for a length that is no whole number of steps.
    """
    if line_length is not None:
        steps = line_length / dx
        if abs(steps - round(steps)) > 1e-6:
            raise InputError(
                f"line_length = {line_length:g} m is not a whole number of steps of {dx:g} m: "
                f"give {round(steps) * dx:.12g} m"
            )
        return round(steps)
    on_rails = [each for each in irregularities if each.on in RAILS]
    if not on_rails:
        return 1
    end = max(getattr(each, "end", 0.0) for each in on_rails)
    if end > LONGEST_LINE:
        raise InputError(
            f"irregularities of rails reach to {end:g} m, and rails repeat after at most {LONGEST_LINE:g} m: give "
            f"positions up to that, or a line_length after which they repeat"
        )
    return round(max(math.ceil(end / LINE), 1) * LINE / dx)


def _patches(irregularities: Iterable[Irregularity], surface: Surface, y: Real) -> Iterable[Patch]:
    for each in irregularities:
        if each.on != surface.name:
            continue
        for patch in each.patches(surface, y):
            check_length(each, patch, surface)
            yield patch


def check_length(irregularity: Irregularity, patch: Patch, surface: Surface) -> None:
    """Raise InputError for a patch of an irregularity that is longer than its surface."""
    if len(patch.heights) > surface.steps:
        raise InputError(
            f"{irregularity.type} on {surface.name} is {len(patch.heights) * surface.dx:g} m long: give one that fits "
            f"into the {surface.length:g} m after which the surface repeats"
        )


def _check_heights(heights: Real, surface: Surface) -> None:
    if not np.isfinite(heights).all():
        raise InputError(f"heights of {surface.name} are not finite: give finite irregularities")
    if -heights.min() > DEEPEST or heights.max() > DEEPEST:
        where = "tread of " if surface.name in WHEELS else ""
        raise InputError(
            f"{where}{surface.name} is {max(-heights.min(), heights.max()):.3g} m deep where irregularities overlap: "
            f"give depths that add up to {DEEPEST:g} m at most"
        )
