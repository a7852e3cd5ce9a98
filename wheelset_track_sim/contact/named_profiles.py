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
from ..inputs.text_files import exists, is_file
from .profile_files import ProfileColumns, ProfileFile, columns_of, read_points, shaped
from .profiles import LateralProfile, Points, RailHead, Straight

COMPUTED: dict[str, dict[str, LateralProfile]] = {
    "wheel": {"cylinder": Straight(), "cone_1_40": Straight(1 / 40), "cone_1_20": Straight(1 / 20)},
    "rail": {"head_60e1": RailHead()},
}
"""Profiles of each side that need no points."""


def load_profile(side: str, source: str | Path | Mapping[str, Any], where: str = "profile") -> LateralProfile:
    """Load the lateral profile of a ``wheel`` or a ``rail``.

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
        If there is no such profile or file, or its points cannot be used.
    """
    return read_profile(side, with_points(side, source, where), where)


def read_profile(side: str, data: Any, where: str) -> LateralProfile:
    """Profile from a name or a mapping of points, which are used as they are; opens no file.

    Raises InputError, which begins with ``where``.
    """
    if isinstance(data, str) and data in known_names(side):
        return _named(side, data)
    if isinstance(data, Mapping):
        try:
            columns = read(ProfileColumns, data, f"points of a {side}")
            return Points(np.array(columns.y), np.array(columns.z))
        except InputError as refusal:
            raise InputError(f"{where}: {refusal}") from None
    if not hasattr(data, "span"):
        raise InputError(f"{where}: {unknown(f'profile of a {side}', repr(str(data)), str(data), known_names(side))}")
    return data  # type: ignore[no-any-return]


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
    """What a user gives for a profile, as ``read_profile`` takes it: points of files, with their axes turned if needed.

    Raises InputError, which begins with ``where``, and warns of axes that it turns.
    """
    try:
        if isinstance(source, Mapping) and "file" not in source:
            given = read(ProfileColumns, source, f"points of a {side}")
            y, z = shaped(side, np.array(given.y), np.array(given.z), where)
            return {"y": y.tolist(), "z": z.tolist()}
        if isinstance(source, Mapping):
            file = read(ProfileFile, source, f"file of a {side}")
        elif isinstance(source, (str, Path)) and str(source) not in known_names(side):
            file = ProfileFile(str(source))
        else:
            return source
        _check_exists(side, Path(file.file))
        columns = read_points(side, file)
    except InputError as refusal:
        raise InputError(f"{where}: {refusal}") from None
    return {"y": list(columns.y), "z": list(columns.z)}


def _check_exists(side: str, path: Path) -> None:
    """Raise InputError for a path where no file is; it may be a name that was misspelled."""
    if is_file(path):
        return
    if not (path.suffix or exists(path)):
        raise InputError(unknown(f"profile of a {side}", repr(str(path)), str(path), known_names(side)))
    found = "is no file" if exists(path) else "does not exist"
    raise InputError(f"{path} {found}: give a file with y and z, or one of {', '.join(known_names(side))}")


@cache
def _named(side: str, name: str) -> LateralProfile:
    if name in COMPUTED[side]:
        return COMPUTED[side][name]
    y, z = columns_of(read_table(shipped.file(f"{side}_profiles", f"{name}.csv")))
    return Points(*shaped(side, y, z, name))
