"""Units: SI in files for programs, those of the railway in text and figures for people."""

from __future__ import annotations

import typing
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from ..irregularities.kinds import kind_named, known_kinds
from ..scenario.scenario import BAND, Scenario


@dataclass(frozen=True)
class Unit:
    """A unit with its size in SI."""

    name: str
    size: float = 1.0


FOR_PEOPLE = {
    "m/s": Unit("km/h", 1 / 3.6),
    "m": Unit("mm", 1e-3),
    "N": Unit("kN", 1e3),
    "Pa": Unit("MPa", 1e6),
    "s": Unit("ms", 1e-3),
}
"""What people read in the place of an SI unit; the others are read as they are."""

ACCEPTED = {unit.name: (si, unit) for si, unit in FOR_PEOPLE.items()} | {"t": ("N", Unit("t", 9810.0))}
"""Units beside SI in which a study may give values, by name, with the SI unit."""


def for_people(si: str) -> Unit:
    """The unit in which people read a quantity of the SI unit ``si``."""
    return FOR_PEOPLE.get(si, Unit(si))


def text(quantity: str, unit: str) -> str:
    """A quantity with its unit, as over a column or along an axis."""
    return f"{quantity} ({unit})" if unit else quantity


def meaning(key: str) -> tuple[str, str]:
    """What a dotted scenario key means, and its SI unit; the key itself and no unit if it is not a quantity."""
    if key == "max_frequency":  # it may be None, so that its declaration stands apart
        return BAND.meaning.removeprefix("the "), BAND.unit
    owners: set[type] = {Scenario}
    found = (key, "")
    for part in key.split("."):
        inner: set[type] = set()
        for owner in owners:
            if part.isdigit():
                inner.add(owner)
            for field in fields(owner):
                if field.name == part:
                    declared = field.metadata.get("quantity")
                    found = (declared.meaning.removeprefix("the "), declared.unit) if declared else found
                    inner |= _kinds() if part == "irregularities" else _dataclasses(_hint(owner, part))
        owners = inner
    return found


def _kinds() -> set[type]:
    return {kind_named(name).factory for name in known_kinds()}


def _hint(owner: type, name: str) -> Any:
    return typing.get_type_hints(owner)[name]


def _dataclasses(hint: Any) -> set[type]:
    """Dataclasses that stand anywhere in a type hint."""
    if isinstance(hint, type) and is_dataclass(hint):
        return {hint}
    return {found for part in typing.get_args(hint) for found in _dataclasses(part)}
