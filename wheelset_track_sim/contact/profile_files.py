"""Files of lateral profiles: text tables, YAML, MiniProf and Simpack.

* MiniProf (``.whl``, ``.rail``, ``.ban``): lines ``key=value``, an empty line, and points whose first two numbers are y
  and z in mm. The manual of the program CONV_MINIPROF2KPF of Gensys describes it so.
* Simpack (``.prw``, ``.prr``): comments in these files describe their keys. Points are between ``point.begin`` and
  ``point.end``, z counts downwards; ``_simpack`` applies the keys in the order of the numbers in the comments.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ..errors import InputError
from ..inputs.schema import check, quantity, read
from ..inputs.tables import Column, ColumnTable, read_table
from ..inputs.text_files import read_text
from ..inputs.yaml12 import parse
from ..runtime.arrays import Real
from .orientation import Turn, oriented
from .profiles import FEWEST

MINIPROF = (".whl", ".rail", ".ban")
SIMPACK = {".prw": "wheel", ".prr": "rail"}
DATUM = 0.010
"""Where z of a wheel at y = 0 is farther from 0, m, it does not count from the rolling circle."""
RISING = 1e-6
"""What y rises by from point to point at least, m, where a profile does not overhang."""


@dataclass(frozen=True)
class ProfileFile:
    """A file of points, and what it does not say itself."""

    file: str
    column: str = ""
    """Name or number of the column of heights, where a table has several."""
    unit: Literal["", "m", "mm", "cm", "um"] = ""
    """Of y and z, where the headings of a table give none."""
    turn: Turn = "auto"
    """Axes to turn; ``auto`` recognises them by the shape."""
    origin: float = quantity(
        "m", -2.0, 2.0, "y in the file of the rolling circle or the middle of the head", default=0.0
    )

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class ProfileColumns:
    """Points of a profile, m: y rising to the field side, z positive where there is more material."""

    y: tuple[float, ...]
    z: tuple[float, ...]


def read_points(side: str, given: ProfileFile) -> ProfileColumns:
    """Points of a file of a ``wheel`` or ``rail``; raises InputError, and warns of axes that it turns."""
    path = Path(given.file)
    suffix = path.suffix.lower()
    if suffix in (".yaml", ".yml"):
        points = read(ProfileColumns, parse(read_text(path), given.file), given.file)
        y, z = np.array(points.y), np.array(points.z)
    elif suffix in SIMPACK:
        if SIMPACK[suffix] != side:
            raise InputError(f"{path} is the Simpack file of a {SIMPACK[suffix]}: give the file of a {side}")
        y, z = _simpack(read_text(path), given.file)
    elif suffix in MINIPROF:
        y, z = columns_of(read_table(path), given.column or "2", "mm")
    else:
        y, z = columns_of(read_table(path), given.column, given.unit)
    if given.origin:
        y = y - given.origin
    try:
        y, z = shaped(side, y, z, given.file, given.turn)
    except InputError as refusal:
        raise InputError(f"{path}: {refusal}") from None
    if suffix in (*SIMPACK, *MINIPROF):
        y, z = _without_overhang(y, z)
    return ProfileColumns(tuple(y.tolist()), tuple(z.tolist()))


def shaped(side: str, y: Real, z: Real, name: str, turn: Turn = "auto") -> tuple[Real, Real]:
    """Points as ``ProfileColumns`` has them, from points whose axes may be turned; raises InputError.

    z of a wheel counts from its rolling circle on. A worn wheel may have its loss there, but nothing beyond
    ``DATUM``.
    """
    if y.shape != z.shape or y.size < FEWEST or not (np.isfinite(y).all() and np.isfinite(z).all()):
        return y, z  # which makes no profile
    y, z = oriented(side, y, z, name, turn)
    datum = float(np.interp(0.0, y, z))
    return y, (z - datum if side == "wheel" and abs(datum) > DATUM else z)


def columns_of(table: ColumnTable, column: str = "", unit: str = "") -> tuple[Real, Real]:
    """Return y and z of a table, m; ``column`` and ``unit`` as in ``ProfileFile``."""
    named = any(each.name for each in table.columns)
    if column:
        high = table.chosen(column, "the heights")
    elif found := table.find("z"):
        high = found
    elif named or len(table.columns) != 2:
        raise InputError(
            f"{table.source} has no column z: give column, the name of the column of heights: {table.listed()}"
        )
    else:
        high = table.columns[1]
    across = table.find("y") or table.columns[0]
    if across is high:
        across = table.columns[0] if high is not table.columns[0] else table.columns[1]
    return _metres(table, across, unit), _metres(table, high, unit)


def _metres(table: ColumnTable, column: Column, unit: str) -> Real:
    size = table.size(column, "length", unit or None)
    missing = np.flatnonzero(np.isnan(column.values))
    if len(missing):
        raise InputError(
            f"{table.where(missing[0])} has no {column.heading or 'value'}: give one, or leave the line out"
        )
    # rounded: the decimals of the file, in m
    return np.array([round(value * size, 12) for value in (column.values + column.origin).tolist()])


def _simpack(text: str, name: str) -> tuple[Real, Real]:
    """Return y and z of a Simpack file, m, z positive upwards."""
    lines = [line.partition("!")[0].strip() for line in text.splitlines()]
    if "point.begin" not in lines or "point.end" not in lines:
        raise InputError(f"{name} has no points between point.begin and point.end: give a Simpack profile")
    begin, end = lines.index("point.begin"), lines.index("point.end")
    keys = dict(re.findall(r"^([\w.]+) *= *(.+)$", "\n".join(lines[:begin]), re.MULTILINE))
    try:
        points = np.array([[float(cell) for cell in line.split()[:2]] for line in lines[begin + 1 : end] if line])

        def number(key: str, default: float = 0.0) -> float:
            found = float(keys.get(key, default))
            if not math.isfinite(found) or (key.startswith("units.") and found <= 0.0):
                raise ValueError(f"{key} = {found:g}")  # noqa: TRY301
            return found

        y, z = points.T
        y, z = y + number("shift.y"), z + number("shift.z")
        angle = number("rotate") / number("units.ang.f", 1.0)
        y, z = y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)
        kept = np.ones(len(y), bool)
        for key, values in (("bound.y", y), ("bound.z", z)):
            low, high = number(f"{key}.min", 1.0), number(f"{key}.max", 0.0)
            if low < high:  # otherwise there is no bound
                kept &= (values >= low) & (values <= high)
        y, z = y[kept], z[kept]
        y, z = (-y if number("mirror.y") else y), (-z if number("mirror.z") else z)
        factor = number("units.len.f", 1.0)
    except ValueError as reason:
        raise InputError(
            f"{name} is not a Simpack profile ({reason}): give keys with numbers, and rows of y and z"
        ) from None
    return y / factor, -z / factor


def _without_overhang(y: Real, z: Real) -> tuple[Real, Real]:
    """Points from the middle outwards, as far as y rises: the sides of a measured profile overhang, or hang back."""
    middle = int(np.abs(y).argmin())
    back = np.flatnonzero(np.diff(y) < RISING)
    first = int(back[back < middle].max(initial=-1)) + 1
    last = int(back[back >= middle].min(initial=len(y) - 1)) + 1
    return y[first:last], z[first:last]
