"""What a dotted scenario key means, from the declaration of its quantity."""

from __future__ import annotations

from ..inputs.schema import Quantity
from .quantities import quantity_within
from .scenario import Scenario


def meaning_of(key: str) -> tuple[str, str]:
    """What a dotted scenario key means, and its SI unit; the key itself and no unit if it is not a quantity."""
    found = quantity_at(key)
    return (key, "") if found is None else (found.meaning.removeprefix("the "), found.unit)


def quantity_at(key: str) -> Quantity | None:
    """Quantity of a dotted scenario key; None if it is none. Of several kinds of irregularities, that of the last."""
    return quantity_within([Scenario], key.split("."))
