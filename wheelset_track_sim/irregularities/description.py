"""Irregularities in words, from their plain mappings: for tables and pages that people read."""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..errors import InputError
from ..inputs.schema import Quantity
from ..inputs.units import ShownUnit, for_people
from .kinds import kind_named

LONGEST = 60
"""Characters of a text, such as the table of a measured tread, that is shown whole."""
HUGE = 1e300
"""Numbers beyond it have no text in units: a file may hold whole numbers of any size."""
MOST = 12
"""Entries of a list that are shown."""


def description_of(item: Mapping[str, Any]) -> str:
    """Words for an irregularity: its type, where it is, and all its values, in the units that people use.

    Parameters
    ----------
    item
        Plain mapping, as in a scenario file. A type that is not known here is described by its keys, in SI units.

    Returns
    -------
    str
        Such as ``flat on wheel_1: length 60 mm, angle 0°``.
    """
    name = str(item.get("type", "irregularity of unknown type"))
    try:
        owner: Any = kind_named(name).factory
    except InputError:
        owner = None
    values = {key: value for key, value in item.items() if key not in ("type", "on", "package")}
    words = ", ".join(_values(values, owner))
    return f"{name} on {item.get('on', 'an unknown surface')}{': ' if words else ''}{words}"


def _values(values: Mapping[str, Any], owner: Any) -> Iterator[str]:
    declared = {field.name: field for field in dataclasses.fields(owner)} if owner else {}
    for key, value in values.items():
        if value is None or value in ("", [], {}):  # not given
            continue
        field = declared.get(key)
        quantity: Quantity | None = field.metadata.get("quantity") if field else None
        named = quantity.meaning.removeprefix("the ").partition(",")[0] if quantity and len(key) == 1 else key
        yield f"{named.replace('_', ' ')} {_value(value, quantity, _inner(owner, key) if field else None)}"


def _value(value: Any, quantity: Quantity | None, inner: Any) -> str:
    if isinstance(value, Mapping):
        return f"({', '.join(_values(value, inner))})"
    if isinstance(value, Sequence) and not isinstance(value, str):
        shown = [_value(each, None, inner) for each in value[:MOST]]
        more = [f"and {len(value) - MOST} more"] if len(value) > MOST else []
        return f"[{', '.join([*shown, *more])}]"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        if abs(value) > HUGE:
            return f"beyond {HUGE:g}"
        if quantity is None:
            return f"{value:.6g}"
        if quantity.unit == "rad":
            return f"{math.degrees(value):.6g}°"
        unit = ShownUnit("m") if quantity.unit == "m" and abs(value) >= 1.0 else for_people(quantity.unit)
        return f"{value / unit.size:.6g} {unit.name}".rstrip()
    text = str(value)
    return text if len(text) <= LONGEST else f"of {len(text.splitlines())} lines"


def _inner(owner: Any, key: str) -> Any:
    """The dataclass of the entries of a field, if there is one alone."""
    found = [
        each
        for each in typing.get_args(typing.get_type_hints(owner).get(key))
        if isinstance(each, type) and dataclasses.is_dataclass(each)
    ]
    return found[0] if len(found) == 1 else None
