"""Points of lateral profiles: files of columns with units, and what a scenario holds of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import read, unknown
from ..inputs.yaml12 import parse

COMPUTED = {"wheel": ("cylinder", "cone_1_40", "cone_1_20"), "rail": ("head_60e1",)}
"""Profiles that need no points."""
UNITS = {"m": 1.0, "mm": 1e-3}
FILES = (".csv", ".yaml", ".yml")
HEADER = re.compile(r"y_(mm|m),z_(mm|m)")


@dataclass(frozen=True)
class ProfilePoints:
    """Points of a profile, m: y rising to the field side, z positive where there is more material."""

    y: tuple[float, ...]
    z: tuple[float, ...]

    def plain(self) -> dict[str, list[float]]:
        """As a scenario file has them."""
        return {"y": list(self.y), "z": list(self.z)}


def load_points(side: str, source: str | Path | Mapping[str, Any]) -> ProfilePoints:
    """Points of a ``wheel`` or ``rail``: of a shipped name, a CSV or YAML file, or a mapping with y and z.

    Raises InputError for what cannot be read.
    """
    if isinstance(source, Mapping):
        return read(ProfilePoints, source, f"points of a {side}")
    name, kind = str(source), f"{side}_profiles"
    path = Path(name)
    if name in shipped.names(kind, ".csv"):
        return _columns(shipped.text(kind, f"{name}.csv"), name)
    if side not in COMPUTED or path.suffix not in FILES:
        known = [*COMPUTED.get(side, ()), *shipped.names(kind, ".csv")]
        raise InputError(unknown(f"profile of a {side}", repr(name), name, known))
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        raise InputError(f"{path} cannot be read ({reason}): give a CSV or YAML file with y and z") from None
    return _columns(text, name) if path.suffix == ".csv" else read(ProfilePoints, parse(text, name), name)


def _columns(text: str, name: str) -> ProfilePoints:
    """Two columns below a heading with their units; lines that begin with ``#`` say what they are."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    header = HEADER.fullmatch(lines[0][1].replace(" ", "").lower()) if lines else None
    if header is None:
        found = repr(lines[0][1][:40]) if lines else "nothing"
        raise InputError(f"{name}: {found} does not name columns and units: give y_mm,z_mm or y_m,z_m above the points")
    units = [UNITS[unit] for unit in header.groups()]
    rows = [_numbers(line, f"{name}, line {number}") for number, line in lines[1:]]
    y, z = (tuple(round(row[column] * units[column], 12) for row in rows) for column in (0, 1))
    return ProfilePoints(y, z)


def _numbers(line: str, where: str) -> tuple[float, float]:
    try:
        y, z = map(float, line.split(","))
    except ValueError:
        raise InputError(f"{where}: {line[:40]!r} is not two numbers with a comma between") from None
    return y, z
