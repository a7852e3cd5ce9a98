"""Files of measured samples: CSV and NumPy."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import InputError
from ..inputs.shipped import table_text
from ..runtime.arrays import Real

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

LARGEST = 8_000_000
"""Bytes of a file at most."""
MOST = 200_000
"""Numbers of a file at most: they become part of the scenario, and of its bag."""


class Samples(NamedTuple):
    """Samples along a surface."""

    along: Real
    """Positions along, (n,)."""
    values: Real
    """Heights, (n, columns); NaN where there is none."""
    across: Real | None
    """Positions across, (columns,); None for one column that is the same all across."""


def read_table(source: Traversable | Path) -> str:
    """Numbers of a file as text, a row a line; raises InputError for a file that is not a CSV or NumPy file of them.

    In CSV, a first line of names and lines that begin with ``#`` are passed over, and empty cells have no value.
    """
    try:
        with source.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as reason:
        raise InputError(f"file {source} cannot be read ({reason}): give a CSV or NumPy file") from None
    if len(content) > LARGEST:
        raise InputError(f"file {source} has more than {LARGEST} bytes: give fewer samples")
    table = _from_numpy(content, source.name) if source.name.endswith(".npy") else _from_text(content, source.name)
    if table.ndim != 2 or table.size > MOST:
        raise InputError(f"file {source.name} is a table of {table.shape}: give two dimensions, {MOST} numbers at most")
    return table_text(table)


def samples_of(text: str, name: str) -> Samples:
    """Samples of a table in its own units: two columns, or a first row of positions across and a column along.

    Raises InputError, which calls the table ``name``, for one that is not such a table.
    """
    if len(text) > LARGEST:
        raise InputError(f"table of {name} has {len(text)} characters: give at most {LARGEST}")
    try:
        rows = [[float(cell) for cell in line.split()] for line in text.splitlines()]
        table = np.array(rows, dtype=np.float64)
    except ValueError as reason:
        raise InputError(f"table of {name} is no table of numbers ({' '.join(str(reason).split())})") from None
    if table.ndim != 2 or table.shape[1] < 2 or len(table) < 5 or table.size > MOST:
        raise InputError(
            f"file {name} is a table of {table.shape}: give at least 5 rows and 2 columns, {MOST} numbers at most"
        )
    if table.shape[1] == 2:
        along, values, across = table[:, 0], table[:, 1:], None
    else:
        along, values, across = table[1:, 0], table[1:, 1:], table[0, 1:]
        if not np.isfinite(across).all() or len(set(across)) < len(across):
            raise InputError(f"file {name} has no positions across in its first row: give one for each column")
    if not np.isfinite(along).all() or np.isinf(values).any():
        raise InputError(f"file {name} holds positions or values that are not finite: give numbers")
    return Samples(along, values, across)


def _from_numpy(content: bytes, name: str) -> Real:
    try:
        array = np.load(io.BytesIO(content), allow_pickle=False)
    except (ValueError, OSError, EOFError) as reason:
        raise InputError(f"file {name} is not a NumPy file ({reason}): give one that numpy.save has written") from None
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
        raise InputError(f"file {name} is no array of real numbers: give one")
    return array.astype(np.float64)


def _from_text(content: bytes, name: str) -> Real:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as reason:
        raise InputError(f"file {name} is not text ({reason}): give a CSV file, or one called .npy") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    delimiter = next((mark for mark in (";", "\t", ",") if lines and mark in lines[0]), ",")
    rows: list[list[float]] = []
    for number, cells in enumerate(csv.reader(lines, delimiter=delimiter)):
        try:
            numbers = [_number(cell, first=number == 0 and place == 0) for place, cell in enumerate(cells)]
        except ValueError:
            if number == 0:
                continue  # names
            raise InputError(f"file {name} has {cells!r:.60} in row {number + 1}: give numbers") from None
        if rows and len(numbers) != len(rows[0]):
            raise InputError(f"file {name} has {len(numbers)} cells in row {number + 1}: give {len(rows[0])} as before")
        rows.append(numbers)
    return np.array(rows) if rows else np.zeros((0, 0))


def _number(cell: str, *, first: bool) -> float:
    """A cell; the corner of a table may hold anything, empty ones hold nothing."""
    try:
        return float(cell) if cell.strip() else math.nan
    except ValueError:
        if first:
            return math.nan
        raise
