"""Quantities of nested dataclasses by the parts of a dotted key."""

from __future__ import annotations

import typing
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from ..inputs.schema import Quantity
from ..irregularities.kinds import kind_named, known_kinds

OF_IRREGULARITIES = ("irregularities", "add", "replace")
"""Keys of a scenario, and of its events, below which irregularities are."""


def quantity_within(owners: Sequence[type], parts: Sequence[str]) -> Quantity | None:
    """Quantity that the parts of a dotted key name in dataclasses; None if it is none. Of several, the last one's."""
    found: Quantity | None = None
    for part in parts:
        inner: list[type] = []
        for owner in owners:
            if part.isdecimal():
                inner.append(owner)
            for field in fields(owner):
                if field.name == part:
                    found = field.metadata.get("quantity", found)
                    inner += kinds() if part in OF_IRREGULARITIES else _dataclasses(_hint(owner, part))
        owners = inner
    return found


def kinds() -> list[type]:
    """Dataclasses of all kinds of irregularities."""
    return [kind_named(name).factory for name in known_kinds()]


def _hint(owner: type, name: str) -> Any:
    return typing.get_type_hints(owner)[name]


def _dataclasses(hint: Any) -> list[type]:
    """Dataclasses that stand anywhere in a type hint."""
    if isinstance(hint, type) and is_dataclass(hint):
        return [hint]
    return [found for part in typing.get_args(hint) for found in _dataclasses(part)]
