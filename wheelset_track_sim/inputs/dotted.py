"""Entries of nested mappings and lists by dotted keys, such as ``irregularities.0.h``."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from .amounts import whole_number


def put(data: Any, key: str, value: Any, where: str = "") -> None:
    """Set the entry of a dotted key; list indices count from 0, and mappings that are missing are made.

    Raises InputError that begins with ``where`` and the key for an entry that cannot be.
    """
    *path, last = key.split(".")
    place: Any = data
    for depth, part in enumerate(path):
        place = _entry(place, part, where + ".".join(path[: depth + 1]))
    if isinstance(place, list):
        place[index_of(place, last, where + key)] = value
    elif isinstance(place, dict):
        place[last] = value
    else:
        raise InputError(f"{where}{key}: {'.'.join(path)} has no entries")


def entry(data: Any, key: str, where: str = "") -> Any:
    """The entry of a dotted key; raises InputError that begins with ``where`` and the key if there is none."""
    place: Any = data
    for part in key.split("."):
        if isinstance(place, list):
            place = place[index_of(place, part, where + key)]
        elif isinstance(place, dict) and part in place:
            place = place[part]
        else:
            known = f": known are {', '.join(map(str, place))}" if isinstance(place, dict) else ""
            raise InputError(f"{where}{key}: there is no {part}{known}")
    return place


def index_of(place: list[Any], part: str, where: str) -> int:
    """A list index from its text; raises InputError that begins with ``where`` if the list has no such entry."""
    index = whole_number(part)
    if index is None or index >= len(place):
        raise InputError(f"{where}: {part!r} is not an index of a list with {len(place)} entries (0 is the first)")
    return index


def _entry(place: Any, part: str, where: str) -> Any:
    if isinstance(place, list):
        return place[index_of(place, part, where)]
    if isinstance(place, dict):
        return place.setdefault(part, {})
    raise InputError(f"{where}: there is nothing to set there")
