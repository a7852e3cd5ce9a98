"""Messages read by the definitions that their bag holds, which may be older or newer than those of this version.

Fields that this version does not know are left out. A field that an older definition does not have gets the value that
it would have had then, from ``DEFAULTS``; where nothing can stand for it, the bag is refused.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from mcap.records import Schema
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from .definitions import PACKAGE, deserialise, full_name, typestore

Deserialise = Callable[[memoryview], Any]
Default = Callable[[Any], Any]

UNKNOWN: Default = lambda _: math.nan  # noqa: E731
NONE: Default = lambda _: np.empty(0)  # noqa: E731
DEFAULTS: Mapping[str, Mapping[str, Default]] = {
    "ContactForces": {"decimation": lambda _: 1},
    "AxleStress": {"decimation": lambda _: 1},
    "SimulationState": {"speed_set_point": lambda state: state.speed},
    "LoadSummary": {
        "turns": lambda _: 0,
        **dict.fromkeys(("wheel_1_turn_max_force", "wheel_2_turn_max_force"), UNKNOWN),
        **dict.fromkeys(("turn_max_principal", "stress_max", "stress_min", "stress_mean", "stress_rms"), NONE),
        "max_principal_mean": lambda summary: np.full(len(summary.nodes), math.nan),
        "max_principal_rms": lambda summary: np.full(len(summary.nodes), math.nan),
    },
}
"""Values of fields by message, from the message without them: samples were of every step before they could be
decimated, a changed speed held at once, and means and turns were not counted."""


class DefinitionError(ValueError):
    """A definition in a bag lacks what nothing can stand for."""


@lru_cache(maxsize=64)
def _reader(kind: str, encoding: str, text: str) -> Deserialise:
    name = full_name(kind)
    if encoding != "ros2msg" or not text.strip():
        return lambda data: deserialise(kind, data)
    stored = get_types_from_msg(text, name)
    ours = typestore()
    if all(stored.get(other) == tuple(ours.fielddefs[other]) for other in _within(name)):
        return lambda data: deserialise(kind, data)
    for other in _within(name):
        _check(other, dict(ours.fielddefs[other][1]), dict(stored[other][1]) if other in stored else {})
    theirs = get_typestore(Stores.EMPTY)
    theirs.register(stored)
    return lambda data: _conformed(name, theirs.deserialize_cdr(data, name))


def reader(kind: str, schema: Schema) -> Deserialise:
    """Function from CDR to a message of this version; raises DefinitionError, or what rosbags raises for a bad text."""
    return _reader(kind, schema.encoding, schema.data.decode())


def _within(name: str) -> list[str]:
    """A message of the package, and those of the package that it holds."""
    fields = typestore().fielddefs[name][1]
    inner = [of[1][0] if of[0] == Nodetype.SEQUENCE else of for _, of in fields]
    held = [of[1] for of in inner if of[0] == Nodetype.NAME and of[1].startswith(f"{PACKAGE}/")]
    return [name, *(other for each in held for other in _within(each))]


def _check(name: str, ours: dict[str, Any], stored: dict[str, Any]) -> None:
    kind = name.rpartition("/")[2]
    for field, of in ours.items():
        if field not in stored and field not in DEFAULTS.get(kind, {}):
            raise DefinitionError(f"{kind} has no {field}")
        if field in stored and stored[field] != of:
            raise DefinitionError(f"{kind} has another type of {field}")


def _conformed(name: str, found: Any) -> Any:
    """A message with the fields of this version."""
    told = SimpleNamespace()
    missing = []
    for field, of in typestore().fielddefs[name][1]:
        if not hasattr(found, field):
            missing.append(field)
            continue
        value = getattr(found, field)
        inner, many = (of[1][0], True) if of[0] == Nodetype.SEQUENCE else (of, False)
        if inner[0] == Nodetype.NAME and inner[1].startswith(f"{PACKAGE}/"):
            value = [_conformed(inner[1], one) for one in value] if many else _conformed(inner[1], value)
        setattr(told, field, value)
    for field in missing:
        setattr(told, field, DEFAULTS[name.rpartition("/")[2]][field](told))
    return told
