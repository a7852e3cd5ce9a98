"""What a dotted scenario key means, from the declaration of its quantity."""

from __future__ import annotations

import typing
from dataclasses import fields, is_dataclass
from typing import Any

from ..inputs.schema import Quantity
from ..irregularities.kinds import kind_named, known_kinds
from .scenario import Scenario


def meaning_of(key: str) -> tuple[str, str]:
    """What a dotted scenario key means, and its SI unit; the key itself and no unit if it is not a quantity."""
    found = quantity_at(key)
    return (key, "") if found is None else (found.meaning.removeprefix("the "), found.unit)


def quantity_at(key: str) -> Quantity | None:
    """Quantity of a dotted scenario key; None if it is none. Of several kinds of irregularities, that of the last."""
    owners: list[type] = [Scenario]
    found: Quantity | None = None
    for part in key.split("."):
        inner: list[type] = []
        for owner in owners:
            if part.isdecimal():
                inner.append(owner)
            for field in fields(owner):
                if field.name == part:
                    found = field.metadata.get("quantity", found)
                    inner += _kinds() if part == "irregularities" else _dataclasses(_hint(owner, part))
        owners = inner
    return found


def _kinds() -> list[type]:
    return [kind_named(name).factory for name in known_kinds()]


def _hint(owner: type, name: str) -> Any:
    return typing.get_type_hints(owner)[name]


def _dataclasses(hint: Any) -> list[type]:
    """Dataclasses that stand anywhere in a type hint."""
    if isinstance(hint, type) and is_dataclass(hint):
        return [hint]
    return [found for part in typing.get_args(hint) for found in _dataclasses(part)]
