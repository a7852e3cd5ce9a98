"""Lateral profiles as people give them: names, files of columns with units, and points in a scenario."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import read, unknown
from ..inputs.yaml12 import parse
from .profiles import LateralProfile, Points, RailHead, Straight

COMPUTED: dict[str, dict[str, LateralProfile]] = {
    "wheel": {"cylinder": Straight(), "cone_1_40": Straight(1 / 40), "cone_1_20": Straight(1 / 20)},
    "rail": {"head_60e1": RailHead()},
}
"""Profiles of each side that need no points."""
UNITS = {"m": 1.0, "mm": 1e-3}
FILES = (".csv", ".yaml", ".yml")
HEADER = re.compile(r"y_(mm|m),z_(mm|m)")


@dataclass(frozen=True)
class _Columns:
    """Points of a profile, m: y rising to the field side, z positive where there is more material."""

    y: tuple[float, ...]
    z: tuple[float, ...]


def read_profile(side: str, source: str | Path | Mapping[str, Any] | LateralProfile, where: str) -> LateralProfile:
    """Profile of a ``wheel`` or a ``rail``.

    Parameters
    ----------
    side
        ``wheel`` or ``rail``.
    source
        Name of a profile, path of a CSV or YAML file with y and z, or a mapping with ``y`` and ``z``, m.
    where
        Dotted key that messages begin with.

    Raises
    ------
    InputError
        If there is no such profile, or its points cannot be used.
    """
    try:
        if isinstance(source, (str, Path)):
            known = str(source) in known_names(side)
            return _named(side, str(source)) if known else _points(side, _from_file(side, source))
        if isinstance(source, Mapping):
            return _points(side, read(_Columns, source, f"points of a {side}"))
    except InputError as refusal:
        raise InputError(f"{where}: {refusal}") from None
    if not hasattr(source, "span"):
        raise InputError(
            f"{where}: {unknown(f'profile of a {side}', repr(str(source)), str(source), known_names(side))}"
        )
    return source


def plain_profile(side: str, profile: LateralProfile) -> Any:
    """Name of a profile that has one, or a mapping of its points: ``read_profile`` makes an equal profile of it."""
    for name in known_names(side):
        if _named(side, name) == profile:
            return name
    if isinstance(profile, Points):
        return {"y": profile.y.tolist(), "z": profile.z.tolist()}
    raise InputError(f"a {type(profile).__name__} cannot be written to a file: give a named profile, or points")


def known_names(side: str) -> list[str]:
    """Names of the profiles of a side: those that are computed, then those that are shipped as points."""
    return [*COMPUTED[side], *shipped.names(f"{side}_profiles", ".csv")]


def from_file(side: str, path: str | Path) -> dict[str, list[float]]:
    """Points of a CSV or YAML file as a scenario holds them; raises InputError."""
    columns = _from_file(side, path)
    return {"y": list(columns.y), "z": list(columns.z)}


@cache
def _named(side: str, name: str) -> LateralProfile:
    if name in COMPUTED[side]:
        return COMPUTED[side][name]
    return _points(side, _columns(shipped.text(f"{side}_profiles", f"{name}.csv"), name))


def _from_file(side: str, source: str | Path) -> _Columns:
    name, path = str(source), Path(source)
    if path.suffix not in FILES:
        raise InputError(unknown(f"profile of a {side}", repr(name), name, known_names(side)))
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        raise InputError(f"{path} cannot be read ({reason}): give a CSV or YAML file with y and z") from None
    return _columns(text, name) if path.suffix == ".csv" else read(_Columns, parse(text, name), name)


def _points(side: str, columns: _Columns) -> Points:
    profile = Points(np.array(columns.y), np.array(columns.z))
    if side == "rail":
        middle, *ends = profile.height([0.0, *profile.span])
        if max(ends) > middle:
            raise InputError("z rises from the middle of the head to an end of the points: give z positive upwards")
    return profile


def _columns(text: str, name: str) -> _Columns:
    """Two columns below a heading with their units; lines that begin with ``#`` are comments."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    header = HEADER.fullmatch(lines[0][1].replace(" ", "").lower()) if lines else None
    if header is None:
        found = repr(lines[0][1][:40]) if lines else "nothing"
        raise InputError(f"{name}: {found} does not name columns and units: give y_mm,z_mm or y_m,z_m above the points")
    units = [UNITS[unit] for unit in header.groups()]
    rows = [_numbers(line, f"{name}, line {number}") for number, line in lines[1:]]
    y, z = (tuple(round(row[column] * units[column], 12) for row in rows) for column in (0, 1))
    return _Columns(y, z)


def _numbers(line: str, where: str) -> tuple[float, float]:
    try:
        y, z = map(float, line.split(","))
    except ValueError:
        raise InputError(f"{where}: {line[:40]!r} is not two numbers with a comma between") from None
    return y, z
