"""Lists that come as text over a network, as in a scenario file, bounded in all that they may ask for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import parse
from .kinds import check_number, read_irregularities
from .surface import Irregularity

LONGEST = 256 * 1024
"""Bytes of a text at most."""


def listed(text: str, located: Callable[[str], str]) -> tuple[Irregularity, ...]:
    """Irregularities of a YAML text; an empty one has none.

    ``located`` finds the files that it names, or refuses them. Raises InputError that names the entry.
    """
    data = list_of(text, "irregularities")
    check_number(len(data))
    locate_files(data, located)
    return read_irregularities(data, "irregularities")


def list_of(text: str, what: str) -> list[Any]:
    """The plain list of a YAML text that is not trusted; an empty text is an empty one. Raises InputError."""
    size = len(text.encode(errors="surrogatepass"))
    if size > LONGEST:
        raise InputError(f"{what} have {size} bytes: give at most {LONGEST}, and put longer tables into files")
    data = parse(text, what, trusted=False) or []
    if not isinstance(data, list):
        raise InputError(f"{what} are a {type(data).__name__}: give a list, as in a scenario file")
    return data


def locate_files(data: list[Any], located: Callable[[str], str]) -> None:
    """Give the files that plain irregularities name as ``located`` finds them; those whose content is there stay."""
    for item in data:
        held = isinstance(item, dict) and (item.get("table") or item.get("spectrum"))  # what was in the file
        if isinstance(item, dict) and isinstance(item.get("file"), str) and item["file"] and not held:
            item["file"] = located(item["file"])
