"""Irregularities as a text that comes over a network: the list of a scenario file, bounded in all it may ask for."""

from __future__ import annotations

from collections.abc import Callable

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
    size = len(text.encode(errors="surrogatepass"))
    if size > LONGEST:
        raise InputError(f"irregularities have {size} bytes: give at most {LONGEST}, and put longer tables into files")
    data = parse(text, "irregularities", trusted=False) or []
    if not isinstance(data, list):
        raise InputError(f"irregularities are a {type(data).__name__}: give a list, as in a scenario file")
    check_number(len(data))
    for item in data:
        held = isinstance(item, dict) and (item.get("table") or item.get("spectrum"))  # what was in the file
        if isinstance(item, dict) and isinstance(item.get("file"), str) and item["file"] and not held:
            item["file"] = located(item["file"])
    return read_irregularities(data, "irregularities")
