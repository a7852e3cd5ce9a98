"""Samples along a surface: taken from a file as text that a scenario holds, and read from that text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import InputError
from ..inputs.shipped import table_text
from ..inputs.tables import Column, ColumnTable, read_table
from ..inputs.units import UNITS
from ..runtime.arrays import Real

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable
    from pathlib import Path

ALONG = ("rad", "deg", "m", "mm")
HEIGHT = ("m", "mm", "um")
ACROSS = ("m", "mm")
"""Units that scenarios hold; others of files become m."""
LARGEST = 8_000_000
"""Bytes of a file at most."""
MOST = 200_000
"""Numbers of a file at most: they become part of the scenario, and of its bag."""
PLACES = ("angle", "position", "along")
"""Names of the column of positions along; it is the first one if none is called so."""


class Samples(NamedTuple):
    """Samples along a surface."""

    along: Real
    """Positions along, (n,)."""
    values: Real
    """Heights, (n, columns); NaN where there is none."""
    across: Real | None
    """Positions across, (columns,); None for one column that is the same all across."""


class Taken(NamedTuple):
    """Samples of a file as text, a row a line, with the units of its numbers."""

    text: str
    along: str
    height: str
    across: str


def taken(
    source: Traversable | Path, on: str, column: str, along: str | None, height: str | None, across: str
) -> Taken:
    """Take the samples of a file.

    Parameters
    ----------
    source
        A text or NumPy file with a column of positions along, and one of heights or one for each position across. These
        columns have their positions for names, or in the first row of a file without names, whose corner is empty.
    on
        Surface; of several columns of heights, the one of this name is meant.
    column
        Name or number of the column of heights, or empty.
    along, height, across
        Units of what has none in the headings.

    Raises
    ------
    InputError
        If it is not clear what a column or a unit is, or if the file holds too much.
    """
    table = read_table(source, LARGEST)
    place = next((found for name in PLACES if (found := table.find(name))), table.columns[0])
    others = [each for each in table.columns if each is not place]
    along, stretch = _unit(table, place, along, "along", ALONG)
    positions = None if column or len(others) == 1 else _positions(others, place)
    if positions is None:
        chosen = _heights(table, others, on, column)
        height, factor = _unit(table, chosen, height, "height", HEIGHT)
        rows = np.column_stack([stretch * place.values, factor * chosen.values])
    else:
        if height is None:
            raise InputError(f"{table.source} has one column for each lateral position: give height: {_or(HEIGHT)}")
        across = next((each.unit for each in others if each.unit in ACROSS), across)
        rows = np.column_stack([stretch * place.values, *(each.values for each in others)])
        rows = np.vstack([[np.nan, *positions], rows[1:] if np.isnan(place.values[0]) else rows])
    if rows.size > MOST:
        raise InputError(f"{table.source} holds {rows.size} numbers: give {MOST} at most")
    return Taken(table_text(rows), along, height, across)


def samples_of(text: str, name: str) -> Samples:
    """Samples of a text of ``Taken``: two columns, or a first row of positions across and a column along.

    Raises InputError, which calls the table ``name``, for one that is not such a table.
    """
    if len(text) > LARGEST:
        raise InputError(f"table of {name} has {len(text)} characters: give at most {LARGEST}")
    try:
        rows = [[float(cell) for cell in line.split()] for line in text.splitlines()]
        table = np.array(rows, dtype=np.float64)
    except ValueError as reason:
        raise InputError(f"table of {name} is not a table of numbers ({' '.join(str(reason).split())})") from None
    if table.ndim != 2 or table.shape[1] < 2 or len(table) < 5 or table.size > MOST:
        raise InputError(
            f"file {name} is a table of {table.shape}: give at least 5 rows and 2 columns, {MOST} numbers at most"
        )
    if table.shape[1] == 2:
        along, values, across = table[:, 0], table[:, 1:], None
    else:
        along, values, across = table[1:, 0], table[1:, 1:], table[0, 1:]
        if not np.isfinite(across).all() or len(set(across)) < len(across):
            raise InputError(f"file {name} has no lateral positions in its first row: give one for each column")
    if not np.isfinite(along).all() or np.isinf(values).any():
        raise InputError(f"file {name} holds positions or values that are not finite: give numbers")
    return Samples(along, values, across)


def _heights(table: ColumnTable, others: Sequence[Column], on: str, column: str) -> Column:
    """Column of heights among those that are not along."""
    if column:
        found = table.chosen(column, "the heights")
        if found not in others:
            raise InputError(
                f"{table.source}: column {column!r} holds the longitudinal positions: give the column of the heights"
            )
        return found
    if len(others) == 1:
        return others[0]
    named = [each for each in others if each is table.find(on)]
    if not named:
        raise InputError(
            f"{table.source} has {table.listed()}: give column, the name of the column of heights of {on}; in a table "
            "over lateral positions, name each column by its position"
        )
    return named[0]


def _positions(columns: Sequence[Column], place: Column) -> Real | None:
    """Positions across of columns that are named by them, or have them in the first row; None if they have none."""
    if not any(column.name for column in (place, *columns)) and np.isnan(place.values[0]):
        return np.array([column.values[0] for column in columns])
    try:
        return np.array([float(column.name.replace(",", ".")) for column in columns])
    except ValueError:
        return None


def _unit(table: ColumnTable, column: Column, given: str | None, key: str, known: Sequence[str]) -> tuple[str, float]:
    """Unit of a column that scenarios hold, and the factor that brings its numbers there."""
    if not (column.unit or given):
        what = column.name or f"column {table.columns.index(column) + 1}"
        raise InputError(
            f"{table.source}: {what!r} has no unit: give {key}: {_or(known)}, or write it above the column, such as "
            f"{column.name or key} [{known[1]}]"
        )
    angle = UNITS[given].dimension == "angle" if given else column.unit in ("rad", "deg")
    size = table.size(column, "angle" if angle and "deg" in known else "length", given)
    unit = column.unit or given or ""
    return (unit, 1.0) if unit in known else ("m", size)


def _or(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} or {names[-1]}"
