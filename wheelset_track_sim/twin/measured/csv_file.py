"""CSV files of measured signals: a line of names with units, then one line a sample.

::

    time [s], wheel_1 [kN], wheel_2 [kN], A1_yy [MPa]
    0.0000,   98.1,         97.8,         61.2

Cells are separated by commas, semicolons or tabs; with the latter two numbers may have a decimal comma. A file has one
decimal mark: a comma beside points may separate thousands, and is refused. Lines that are empty or begin with ``#`` are
passed over. The first column is ``time`` or ``position``.
"""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...runtime.arrays import Real
from .measurement import Axis, Measurement

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
    where = f"{path}, line {number}"
    names, scales, axis = _headings(where, _cells(where, first, separator))
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

    Raises InputError if it exists or cannot be written; nothing is left behind then.
    """
    try:
        file = path.open("x", encoding="utf-8", newline="")
    except FileExistsError:
        raise InputError(f"{path} exists already: give another path, or remove it first") from None
    except OSError as reason:
        raise _unwritable(path, reason) from None
    try:
        with file:
            writer = csv.writer(file)
            writer.writerow([f"{axis} [{'s' if axis == 'time' else 'm'}]", *(f"{name} [{unit}]" for name in signals)])
            writer.writerows([repr(float(cell)) for cell in row] for row in zip(at, *signals.values(), strict=True))
    except BaseException as reason:
        path.unlink(missing_ok=True)
        if isinstance(reason, OSError):
            raise _unwritable(path, reason) from None
        raise


def _unwritable(path: Path, reason: OSError) -> InputError:
    return InputError(f"{path} cannot be written ({reason.strerror}): give another path")


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines that say something, with their numbers, read as they are asked for."""
    try:
        size = path.stat().st_size
        if size > LARGEST:
            raise InputError(f"{path} has {size} bytes: give at most {LARGEST}")
        with path.open(encoding="utf-8-sig") as file:
            for number, line in enumerate(file, start=1):
                if line.strip() and not line.lstrip().startswith("#"):
                    yield number, line.rstrip("\n")
    except OSError as reason:
        raise InputError(f"{path} cannot be read ({reason.strerror}): give a CSV file") from None
    except UnicodeDecodeError as reason:
        raise InputError(f"{path} is not text in UTF-8 ({reason.reason}): give a CSV file, saved as UTF-8") from None


def _cells(where: str, line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except csv.Error as reason:
        raise InputError(f"{where} is no line of cells ({reason}): give a CSV file") from None


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
    found = array("d")  # lists of the numbers of a large file do not fit into memory
    before, point = -math.inf, ""
    for number, line in lines:
        where = f"{path}, line {number}"
        cells = _cells(where, line, separator)
        if len(cells) != columns:
            hint = " (decimal commas need semicolons or tabs between cells)" if separator == "," else ""
            raise InputError(f"{where} has {len(cells)} cells: give {columns} as in the first line{hint}")
        for cell in cells:
            mark = "," if "," in cell else "." if "." in cell else point
            if point and mark != point:
                raise InputError(
                    f"{where}: {cell.strip()!r} has {mark!r} where numbers before it have {point!r}: give one decimal "
                    "mark throughout, and none between thousands"
                )
            point = mark
            found.append(_number(where, cell, separator))
        at = found[-columns]
        if at <= before:
            raise InputError(f"{where}: {at:g} is not behind the {before:g} before it: give an axis that increases")
        before = at
    return np.array(found).reshape(-1, columns).T


def _number(where: str, cell: str, separator: str) -> float:
    try:
        value = float(cell.replace(",", ".") if separator != "," else cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {cell.strip()!r} is not a finite number: correct it or leave the line out")
    return value
