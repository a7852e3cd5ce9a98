"""Tables of numbers from files: the one reader of profiles, measured surfaces, spectra and loads."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..runtime.arrays import Real
from .amounts import whole_number
from .numpy_files import UNREADABLE
from .table_rows import Rows, read_rows
from .text_files import LARGEST, opened, opened_text
from .units import UNITS, Dimension, names_of

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

LONGEST = 1_000_000
"""Characters of a line at most."""
COMMENTS = ("#", "%", "!", "//")
"""Marks that begin a line of words."""


@dataclass(frozen=True, eq=False)
class Column:
    """A column of a table."""

    name: str
    """As in the heading, without the unit; empty if the file does not name it."""
    unit: str
    """As in ``units.UNITS``; as the file spells it if it is none of these, and empty if the file gives none."""
    values: Real
    """(n,), in ``unit``, less ``origin``; NaN where a cell is empty."""
    origin: int = 0
    """Whole number that is taken off time stamps, which are exact so: seconds since 1970 of date and time."""

    @property
    def heading(self) -> str:
        """Name and unit, as messages show them."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True, eq=False)
class ColumnTable:
    """Columns of numbers of equal length, two at least."""

    source: str
    """File, as messages name it."""
    columns: tuple[Column, ...]
    lines: NDArray[np.int32]
    """Line of the file of each row, (n,)."""

    def where(self, row: int) -> str:
        """Place of a row, for messages."""
        return f"{self.source}, line {self.lines[row]}"

    def listed(self) -> str:
        """The columns, for messages."""
        return ", ".join(each.heading or f"column {number}" for number, each in enumerate(self.columns, start=1))

    def find(self, name: str) -> Column | None:
        """Column by its name, with or without unit, or by its number, counted from 1; None if there is none."""
        for column in self.columns:
            if key(name) in {key(column.name), key(column.heading), key(f"{column.name} {column.unit}")} - {""}:
                return column
        number = whole_number(name) or 0
        return self.columns[number - 1] if 1 <= number <= len(self.columns) else None

    def chosen(self, name: str, what: str) -> Column:
        """Column that a user names for ``what``; raises InputError with those that there are if there is none."""
        found = self.find(name)
        if found is None:
            raise InputError(f"{self.source} has no column {name!r} for {what}: give one of {self.listed()}")
        return found

    def size(self, column: Column, dimension: Dimension, given: str | None = None) -> float:
        """Size in SI of a column's unit.

        Parameters
        ----------
        column
            One of this table.
        dimension
            What it has to measure.
        given
            Unit of a column whose heading has none; it must not contradict the heading.

        Raises
        ------
        InputError
            If there is no unit, one of another dimension, or another one than ``given``.
        """
        what = repr(column.heading) if column.heading else f"column {self.columns.index(column) + 1}"
        unit, known = column.unit or given or "", names_of(dimension)
        if not unit:
            raise InputError(
                f"{self.source}: {what} has no unit: write {column.name or 'name'} [{known[0]}] above it, or with "
                f"another of {', '.join(known)}"
            )
        if unit not in known:
            raise InputError(f"{self.source}: the unit of {what} is not a unit of {dimension}: give {', '.join(known)}")
        if given and given != unit:
            raise InputError(
                f"{self.source}: the file gives {what} in {unit}, but you gave {given}: correct the file, or leave "
                f"{given} out"
            )
        return UNITS[unit].size


def key(name: str) -> str:
    """Name of a column as names are compared: in small letters, with ``_`` for blanks, points and dashes."""
    return re.sub(r"[\s.\-_()\[\]/]+", "_", name.lower()).strip("_")


def read_table(source: Traversable | Path, largest: int = LARGEST) -> ColumnTable:
    """Read the table of a text file (``table_rows`` says what it may look like), or of a NumPy file (``.npy``).

    Parameters
    ----------
    source
        A text file in an encoding of ``text_files``, or a NumPy file with an array (n, columns), which have no names.
    largest
        Bytes of the file at most.

    Raises
    ------
    InputError
        In one line, with the line of the file, for anything that is no table.
    """
    name = str(source)
    if name.lower().endswith(".npy"):
        with opened(source, largest) as file:
            return _from_numpy(file, name)
    with opened_text(source, largest) as text:
        return _checked(name, read_rows(name, _lines(text, name)))


def _lines(file: IO[str], name: str) -> Iterator[tuple[int, str]]:
    """Lines that say something, with their numbers, read as they are asked for."""
    number = 0
    while line := file.readline(LONGEST + 1):
        number += 1
        if len(line) > LONGEST:
            raise InputError(
                f"{name}, line {number} has more than {LONGEST} characters: put each row of numbers on its own line"
            )
        line = line.rstrip("\n")
        if line.strip() and not line.lstrip().startswith(COMMENTS):
            yield number, line


def _checked(name: str, rows: Rows) -> ColumnTable:
    values = np.array(rows.numbers).reshape(len(rows.lines), -1)
    lines = np.array(rows.lines, np.int32)
    columns = [Column(*heading, column) for heading, column in zip(rows.headings, values.T, strict=True)]
    table = ColumnTable(name, (replace(columns[0], origin=rows.origin), *columns[1:]), lines)
    endless = np.argwhere(np.isinf(values))
    if len(endless):
        row, column = endless[0]
        raise InputError(
            f"{table.where(row)}: {values[row, column]} is not finite: give a number, or leave the line out"
        )
    return table


def _from_numpy(file: IO[bytes], name: str) -> ColumnTable:
    try:
        array = np.load(file, allow_pickle=False)
    except (*UNREADABLE, OSError) as reason:
        raise InputError(f"{name} is not a NumPy file ({reason}): give one that numpy.save has written") from None
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu" or array.ndim != 2 or array.shape[1] < 2:
        found = f"{array.ndim} dimensions of {array.dtype}" if isinstance(array, np.ndarray) else "several arrays"
        raise InputError(f"{name} holds {found}: give real numbers in two dimensions, two columns at least")
    if np.isinf(array).any():
        raise InputError(f"{name} holds numbers that are not finite: give numbers, and NaN where there is none")
    columns = tuple(Column("", "", column) for column in array.astype(np.float64).T)
    return ColumnTable(name, columns, np.arange(1, len(array) + 1, dtype=np.int32))
