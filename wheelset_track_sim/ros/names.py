"""Names of the nodes of a fleet."""

from __future__ import annotations

import re

from ..errors import InputError

LARGEST_FLEET = 100


def fleet_names(text: str, option: str = "--fleet") -> list[str]:
    """Names of the nodes of a fleet from their number or their list; raises InputError that begins with ``option``."""
    if re.fullmatch(r"-?\d+", text):
        return [f"wheelset_{number}" for number in range(1, counted(text, option) + 1)]
    names = text.split(",")
    for name in names:
        if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
            raise InputError(
                f"{option} {text}: {name!r} is not a valid node name: give letters, digits and underscores"
            )
    if len(set(names)) < len(names):
        raise InputError(f"{option} {text} names a node twice: give each its own name")
    return names


def counted(text: str, option: str) -> int:
    """A number of nodes, or of what holds them; raises InputError that begins with ``option``."""
    if not re.fullmatch(r"\d{1,9}", text) or not 1 <= int(text) <= LARGEST_FLEET:
        raise InputError(f"{option} {text} is out of range: give a number of nodes from 1 to {LARGEST_FLEET}")
    return int(text)
