"""All irregularities of a recorded scenario, from its text: also of kinds that this version does not have."""

from __future__ import annotations

import re
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import parse

NONE = "[]"


def irregularities_text(scenario: str) -> str:
    """The YAML list of all irregularities in the YAML text of a scenario.

    It is cut out, not parsed: a measured tread has thousands of lines. ``[]`` is none; empty if the scenario is.
    """
    if not scenario.strip():
        return ""
    found = re.search(r"(?ms)^irregularities:(.*?)(?=^[^\s#-]|\Z)", scenario)
    return (found[1].strip() if found else "") or NONE


def listed_irregularities(scenario: str) -> tuple[Any, ...] | None:
    """The same as plain mappings; None if the scenario is empty or its text holds no such list."""
    try:
        found = parse(irregularities_text(scenario), "irregularities", trusted=False)
    except InputError:
        return None
    return tuple(found) if isinstance(found, list) and all(isinstance(each, dict) for each in found) else None
