"""Rows of numbers from lines of text, and the headings above them.

A file may begin with lines of an instrument or a program. The last line of text before the numbers names the columns,
with or without units: ``y [mm]``, ``y (mm)``, ``y/mm``, ``y_mm``, ``y mm``. Units may have a line of their own, below
the names or alone; a line with ``=`` names nothing. Cells are separated by semicolons, tabs, commas or blanks, and may
be in quotes. Where commas do not separate, numbers may have a decimal comma; a file has one decimal mark, for a comma
beside points may separate thousands. Empty cells have no value. The first cell may be a date and a time.
"""

from __future__ import annotations

import csv
import math
import re
from array import array
from collections import deque
from collections.abc import Iterator, Sequence
from datetime import datetime
from decimal import Decimal, InvalidOperation
from itertools import chain
from typing import NamedTuple

from ..errors import InputError
from .units import unit_named

SEPARATORS = (";", "\t", ",")
STAMPS = 10**8
"""From here on the first column counts from an origin far away, such as 1970, and is read exactly."""
FARTHEST = 10**30
"""Beyond all time stamps, in whatever unit; exact numbers of more digits take long."""
STAMP = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)([.,]\d+)? ?(Z|[-+]\d\d:?\d\d)?", re.ASCII)
HEADING = re.compile(r"(?P<name>[^\[\]()]*?)\s*[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])]")
BETWEEN = re.compile(r"\s*[_/\s]\s*")


class Heading(NamedTuple):
    """What is above a column; empty where nothing is."""

    name: str = ""
    unit: str = ""


class Rows(NamedTuple):
    """Numbers of a file, and what is above them."""

    headings: list[Heading]
    """Of each column."""
    origin: int
    """What is taken off the first column."""
    numbers: array[float]
    """Row by row; lists of the numbers of a large file would not fit into memory."""
    lines: array[int]
    """Line of each row."""


def read_rows(name: str, lines: Iterator[tuple[int, str]]) -> Rows:
    """Rows of numbers of the file ``name`` from its lines and their numbers.

    Raises InputError, with the line, for a file without a row of two numbers or more, and for a row that is none.
    """
    before: deque[tuple[int, str]] = deque(maxlen=2)
    for number, line in lines:
        separator = _separator(line)
        if separator:
            headings = _headings(name, before, _cells(line, separator), separator)
            return _numbers(name, headings, separator, chain([(number, line)], lines))
        before.append((number, line))
    if len(before) < 2:
        raise InputError(f"{name} holds no numbers: give a line of names with units, then one line a row of numbers")
    number, line = before[-1]
    cells = _cells(line, next((mark for mark in SEPARATORS if mark in line), " "))
    raise _no_number(f"{name}, line {number}", next((cell for cell in cells if _value(cell) is None), line))


def _separator(line: str) -> str:
    """What separates the numbers of a line; empty if it is no row of two numbers or more."""
    words = line.split()
    blanks = len(words) > 1 and not any(mark in line for mark in ";\t")
    blanks = blanks and not any(word.startswith(",") or word.endswith(",") for word in words)
    tried = [*([" "] if blanks else []), *[mark for mark in SEPARATORS if mark in line][:1]]
    for separator in tried:
        cells = _without_end(_cells(line, separator))
        values = [_value(cell) for cell in cells]
        if STAMP.fullmatch(cells[0]):
            values[0] = 0.0
        if len(cells) > 1 and None not in values and not all(cell == "" for cell in cells):
            return separator
    return ""


def _headings(name: str, before: Sequence[tuple[int, str]], row: list[str], separator: str) -> list[Heading]:
    """Headings of the columns, from the lines before the first row; InputError if they do not fit it."""
    fewer = _without_end(row)
    if not before or "=" in before[-1][1]:
        return [Heading()] * len(fewer)
    number, line = before[-1]
    cells = _cells(line, separator)
    if len(cells) == len(row) and cells[0] and _value(cells[0]) is not None:
        raise _no_number(f"{name}, line {number}", next((cell for cell in cells if _value(cell) is None), line))
    close = re.sub(r"\s+(?=[\[(])", "", line)
    for found in (cells, _without_end(cells), re.findall(r"\[[^\[\]]*\]", line), close.split(), line.split()):
        if len(found) in (len(row), len(fewer)):
            headings = [_heading(cell) for cell in found[: len(row) if found[-1] else len(fewer)]]
            if any(heading.name for heading in headings) or len(before) < 2:
                return headings
            names = _cells(before[-2][1], separator)  # units alone: names may be above them
            alike = len(names) == len(cells) and len(cells) == len(found)
            return (
                [Heading(each, unit.unit) for each, unit in zip(names, headings, strict=False)] if alike else headings
            )
    if separator != " " and separator in line:
        hint = " (decimal commas need semicolons or tabs between cells)" if separator == "," else ""
        raise InputError(
            f"{name}: line {number} has {len(cells)} cells, and the row of numbers below has {len(row)}: give both the "
            f"same{hint}, or # before a line of words"
        )
    return [Heading()] * len(fewer)


def _heading(cell: str) -> Heading:
    """Name and unit of a heading."""
    found = HEADING.fullmatch(cell)
    if found:
        return Heading(found["name"], unit_named(found["unit"]) or found["unit"])
    if unit_named(cell):
        return Heading("", unit_named(cell))
    for mark in BETWEEN.finditer(cell):
        if unit := unit_named(cell[mark.end() :]):
            return Heading(cell[: mark.start()], unit)
    return Heading(cell)


def _numbers(name: str, headings: list[Heading], separator: str, lines: Iterator[tuple[int, str]]) -> Rows:
    """Numbers of all rows; InputError for a line that is none."""
    numbers, places = array("d"), array("l")
    exact, origin, decimal = False, 0, ""
    for number, line in lines:
        where = f"{name}, line {number}"
        cells = _cells(line, separator)
        if len(cells) == len(headings) + 1 and not cells[-1]:
            cells.pop()
        if len(cells) != len(headings):
            hint = " (decimal commas need semicolons or tabs between cells)" if separator == "," else ""
            raise InputError(f"{where} has {len(cells)} cells: give {len(headings)} as in the lines before{hint}")
        if not places:
            stamp = STAMP.fullmatch(cells[0]) is not None
            exact = stamp or STAMPS <= abs(_value(cells[0]) or 0.0) < FARTHEST
            origin = math.floor(seconds_of(cells[0], where)) if exact else 0
            headings[0] = Heading(headings[0].name, "s") if stamp else headings[0]
        if exact:
            numbers.append(float(seconds_of(cells.pop(0), where) - origin))
        for cell in cells:
            mark = "," if "," in cell else "." if "." in cell else decimal
            if decimal and mark != decimal:
                raise InputError(
                    f"{where}: {cell!r} has {mark!r} where numbers before it have {decimal!r}: give one decimal mark "
                    "throughout, and none between thousands"
                )
            decimal = mark
            value = _value(cell)
            if value is None:
                raise _no_number(where, cell)
            numbers.append(value)
        places.append(number)
    return Rows(headings, origin, numbers, places)


def _cells(line: str, separator: str) -> list[str]:
    """Cells of a line, without blanks and quotes around them."""
    if separator == " ":
        return line.split()
    if '"' in line:
        try:
            line_of_cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
        except csv.Error:  # too long
            return [line]
        return [cell.strip() for cell in line_of_cells]
    return [cell.strip() for cell in line.split(separator)]


def _without_end(cells: list[str]) -> list[str]:
    """Cells without an empty last one, which a separator at the end of a line leaves."""
    return cells if cells[-1] else cells[:-1]


def _value(cell: str) -> float | None:
    """Number of a cell with either decimal mark, NaN of an empty one, None of anything else."""
    try:
        value = float(cell.replace(",", ".")) if cell else math.nan
    except ValueError:
        return None
    return None if "_" in cell else value


def seconds_of(text: str, where: str) -> Decimal:
    """Time stamp: a number, or the seconds since 1970 of a date and time, which is UTC if it names no zone.

    Raises InputError, which begins with ``where``, for anything else.
    """
    cell = text.strip()
    try:
        value = _seconds(cell)
    except (InvalidOperation, ValueError):
        raise _no_number(where, cell) from None
    if not value.is_finite() or not -FARTHEST < value < FARTHEST:
        raise InputError(f"{where}: {cell[:40]!r} is no time: give a number below {FARTHEST:g}")
    return value


def _seconds(cell: str) -> Decimal:
    stamp = STAMP.fullmatch(cell)
    if stamp is None:
        return Decimal(cell.replace(",", "."))
    day, time, part, zone = stamp.groups()
    zone = "+00:00" if zone in (None, "Z") else f"{zone[:3]}:{zone[-2:]}"
    whole = datetime.fromisoformat(f"{day}T{time}{zone}").timestamp()
    return int(whole) + Decimal(f"0.{part[1:]}" if part else 0)


def _no_number(where: str, cell: str) -> InputError:
    return InputError(
        f"{where}: {cell[:40]!r} is not a number: correct it, leave the line out, or put # before a line of words; a "
        "time is a number, or like 2025-11-30T10:53:20.5Z"
    )
