"""CSV files of measured signals: a line of names with units, then one line a sample.

::

    time [s], wheel_1 [kN], wheel_2 [kN], A1_yy [MPa]
    0.0000,   98.1,         97.8,         61.2

Cells are separated by commas, semicolons or tabs; with the latter two numbers may have a decimal comma. Lines that are
empty or begin with ``#`` are passed over. The first column is ``time`` or ``position``.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from ..errors import InputError
from .measurement import Axis, Measurement, Real

AXES: dict[str, tuple[Axis, float]] = {
    "s": ("time", 1.0),
    "ms": ("time", 1e-3),
    "m": ("position", 1.0),
    "mm": ("position", 1e-3),
    "km": ("position", 1e3),
}
"""Axis of a unit, and its size in s or m."""
FORCES = {"N": 1.0, "kN": 1e3}
STRESSES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6}
WHEELS = ("wheel_1", "wheel_2")
LARGEST = 1_000_000_000
"""Bytes of a file at most."""
HEADING = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])]\s*")
SEPARATORS = (";", "\t", ",")


def read_csv(path: str | Path) -> Measurement:
    """Measurement from a CSV file; raises InputError, with the line, for what cannot be used."""
    path = Path(path)
    lines = _lines(path)
    try:
        number, first = next(lines)
    except StopIteration:
        raise InputError(f"{path} holds no line: give a line of names with units, then one line a sample") from None
    separator = next((mark for mark in SEPARATORS if mark in first), ",")
    names, scales, axis = _headings(f"{path}, line {number}", _cells(first, separator))
    columns = _numbers(path, lines, separator, len(names))
    at = columns[0] * scales[0]
    return Measurement(
        path,
        axis,
        at,
        {name: column * scale for name, column, scale in zip(names[1:], columns[1:], scales[1:], strict=True)},
    )


def write_csv(path: Path, axis: Axis, at: Real, signals: Mapping[str, Real], unit: str) -> None:
    """Write signals in ``unit`` (such as ``Pa``) as a file that ``read_csv`` reads, every bit kept.

    Raises InputError if it exists or cannot be written.
    """
    try:
        with path.open("x", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow([f"{axis} [{'s' if axis == 'time' else 'm'}]", *(f"{name} [{unit}]" for name in signals)])
            writer.writerows([repr(float(cell)) for cell in row] for row in zip(at, *signals.values(), strict=True))
    except FileExistsError:
        raise InputError(f"{path} exists already: give another path, or remove it first") from None
    except OSError as reason:
        raise InputError(f"{path} cannot be written ({reason.strerror}): give another path") from None


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines that say something, with their numbers."""
    try:
        size = path.stat().st_size
        if size > LARGEST:
            raise InputError(f"{path} has {size} bytes: give at most {LARGEST}")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as reason:
        raise InputError(f"{path} cannot be read ({reason.strerror}): give a CSV file") from None
    except UnicodeDecodeError as reason:
        raise InputError(f"{path} is not text ({reason.reason}): give a CSV file") from None
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _cells(line: str, separator: str) -> list[str]:
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True))


def _headings(where: str, cells: Iterable[str]) -> tuple[list[str], list[float], Axis]:
    """Names, sizes of the units, and the axis."""
    names: list[str] = []
    scales: list[float] = []
    axis: Axis = "time"
    for index, cell in enumerate(cells):
        found = HEADING.fullmatch(cell)
        if not found:
            raise InputError(f"{where}: {cell.strip()!r} is not of the form name [unit], such as wheel_1 [kN]")
        name, unit = re.sub(r"[\s.-]+", "_", found["name"]), found["unit"]
        if index == 0:
            if unit not in AXES or name.lower() != AXES[unit][0]:
                raise InputError(f"{where}: the first column is {cell.strip()!r}: give time [s] or position [m]")
            axis, scale = AXES[unit]
            names.append(axis)
        elif name.lower() in WHEELS:
            scale = _scale(where, cell, unit, FORCES)
            names.append(name.lower())
        else:
            scale = _scale(where, cell, unit, STRESSES)
            names.append(name)
        if names[-1] in names[:-1]:
            raise InputError(f"{where}: {names[-1]} comes twice: give each column a name of its own")
        scales.append(scale)
    if len(names) < 2:
        raise InputError(f"{where} names one column: give a signal beside {names[0]}, such as wheel_1 [kN]")
    return names, scales, axis


def _scale(where: str, cell: str, unit: str, known: Mapping[str, float]) -> float:
    if unit not in known:
        raise InputError(
            f"{where}: unit of {cell.strip()!r} is not known here: give {', '.join(known)} "
            f"(forces are wheel_1 and wheel_2, stresses have the name of their node)"
        )
    return known[unit]


def _numbers(path: Path, lines: Iterable[tuple[int, str]], separator: str, columns: int) -> Real:
    """Columns (columns, n), the first of them increasing."""
    rows: list[list[float]] = []
    before = -math.inf
    for number, line in lines:
        where = f"{path}, line {number}"
        cells = _cells(line, separator)
        if len(cells) != columns:
            raise InputError(f"{where} has {len(cells)} cells: give {columns} as in the first line")
        row = []
        for cell in cells:
            try:
                value = float(cell.replace(",", ".") if separator != "," else cell)
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise InputError(f"{where}: {cell.strip()!r} is not a finite number: correct it or leave the line out")
            row.append(value)
        if row[0] <= before:
            raise InputError(f"{where}: {row[0]:g} is not behind the {before:g} before it: give an axis that increases")
        before = row[0]
        rows.append(row)
    return np.array(rows).T if rows else np.zeros((columns, 0))
