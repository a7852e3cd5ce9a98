"""Lateral profiles as people give them: names, files, and points in a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import read, unknown
from ..inputs.tables import read_table
from .profile_files import ProfileColumns, ProfileFile, columns_of, read_points, shaped
from .profiles import LateralProfile, Points, RailHead, Straight

COMPUTED: dict[str, dict[str, LateralProfile]] = {
    "wheel": {"cylinder": Straight(), "cone_1_40": Straight(1 / 40), "cone_1_20": Straight(1 / 20)},
    "rail": {"head_60e1": RailHead()},
}
"""Profiles of each side that need no points."""


def read_profile(side: str, source: str | Path | Mapping[str, Any] | LateralProfile, where: str) -> LateralProfile:
    """Profile of a ``wheel`` or a ``rail``.

    Parameters
    ----------
    side
        ``wheel`` or ``rail``.
    source
        Name of a profile, path of a file, a mapping with ``file`` and what the file does not say (``ProfileFile``), or
        a mapping with ``y`` and ``z``, m.
    where
        Dotted key that messages begin with.

    Raises
    ------
    InputError
        If there is no such profile, or its points cannot be used.
    """
    if isinstance(source, (str, Path)) and str(source) in known_names(side):
        return _named(side, str(source))
    if isinstance(source, (str, Path, Mapping)):
        try:
            columns = _columns(side, source)
            return Points(np.array(columns.y), np.array(columns.z))
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


def with_points(side: str, source: Any, where: str) -> Any:
    """``source`` with the points of the file that it names in place of the file; raises InputError."""
    if isinstance(source, str) and source in known_names(side):
        return source
    if isinstance(source, str) or (isinstance(source, Mapping) and "file" in source):
        try:
            columns = _columns(side, source)
        except InputError as refusal:
            raise InputError(f"{where}: {refusal}") from None
        return {"y": list(columns.y), "z": list(columns.z)}
    return source


@cache
def _named(side: str, name: str) -> LateralProfile:
    if name in COMPUTED[side]:
        return COMPUTED[side][name]
    y, z = columns_of(read_table(shipped.file(f"{side}_profiles", f"{name}.csv")))
    return Points(*shaped(side, y, z, name))


def _columns(side: str, source: Any) -> ProfileColumns:
    """Points that a user gives, in a file or not."""
    if isinstance(source, Mapping) and "file" not in source:
        columns = read(ProfileColumns, source, f"points of a {side}")
        y, z = shaped(side, np.array(columns.y), np.array(columns.z), f"points of a {side}")
        return ProfileColumns(tuple(y.tolist()), tuple(z.tolist()))
    given = read(ProfileFile, source, f"file of a {side}") if isinstance(source, Mapping) else ProfileFile(str(source))
    path = Path(given.file)
    if not path.is_file():
        if path.suffix or path.exists():
            found = "is no file" if path.exists() else "does not exist"
            raise InputError(f"{path} {found}: give a file with y and z, or one of {', '.join(known_names(side))}")
        raise InputError(unknown(f"profile of a {side}", repr(given.file), given.file, known_names(side)))
    return read_points(side, given)
