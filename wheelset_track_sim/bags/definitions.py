"""Message definitions without ROS: ``wheelset_track_msgs`` of this version, and the definitions stored in a bag.

The definitions in a bag may be older or newer than this version. Fields that this
version does not have are left out. A field that an older definition lacks gets its value from ``DEFAULTS``; without
such a value the bag is rejected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from importlib.resources import files
from types import SimpleNamespace
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from .irregularities_text import irregularities_text

PACKAGE = "wheelset_track_msgs"
SEPARATOR = "=" * 80 + "\n"
LARGEST = 1 << 17
"""Bytes of a definition."""

Decode = Callable[[bytes | memoryview], Any]
Default = Callable[[Any], Any]

UNKNOWN: Default = lambda _: math.nan  # noqa: E731
NONE: Default = lambda _: np.empty(0)  # noqa: E731
DEFAULTS: Mapping[str, Mapping[str, Default]] = {
    "ContactForces": {"decimation": lambda _: 1},
    "AxleStress": {"decimation": lambda _: 1},
    "SimulationState": {
        "speed_set_point": lambda state: state.speed,
        "irregularities": lambda state: irregularities_text(state.scenario),
    },
    "LoadSummary": {
        **dict.fromkeys(("solved_steps", "filtered_steps", "turns"), lambda _: 0),
        "largest_estimate": UNKNOWN,
        **dict.fromkeys(("wheel_1_turn_max_force", "wheel_2_turn_max_force"), UNKNOWN),
        **dict.fromkeys(("turn_max_principal", "stress_max", "stress_min", "stress_mean", "stress_rms"), NONE),
        "max_principal_mean": lambda summary: np.full(len(summary.nodes), math.nan),
        "max_principal_rms": lambda summary: np.full(len(summary.nodes), math.nan),
    },
}
"""Values of fields that older definitions lack, by message; each is made from the message without these fields."""


class DefinitionError(ValueError):
    """A definition in a bag lacks a field that has no default."""


def full_name(kind: str) -> str:
    """Full type name of a message of the package, such as ``wheelset_track_msgs/msg/AxleStress``."""
    return f"{PACKAGE}/msg/{kind}"


def short_name(name: str) -> str:
    """Short name of a message of the package; empty for other types."""
    package, _, kind = name.partition("/msg/")
    return kind if package == PACKAGE else ""


@cache
def texts() -> dict[str, str]:
    """Definition of every message of the package by its short name, comments included."""
    folder = files("wheelset_track_sim") / "data" / "msg_defs" / "msg"
    return {
        entry.name.removesuffix(".msg"): entry.read_text(encoding="utf-8")
        for entry in sorted(folder.iterdir(), key=lambda entry: entry.name)
        if entry.name.endswith(".msg")
    }


@cache
def typestore() -> Typestore:
    """Types of ROS 2 Jazzy and of the package."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for kind, text in texts().items():
        store.register(get_types_from_msg(text, full_name(kind)))
    return store


@cache
def schema(kind: str) -> str:
    """The ``ros2msg`` schema of a message: its definition, then the definitions of all messages within it."""
    bare, _ = typestore().generate_msgdef(full_name(kind), ros_version=2)
    parts = [texts()[kind]]
    for part in bare.split(SEPARATOR)[1:]:
        title, _, body = part.partition("\n")
        parts.append(f"{title}\n{texts().get(title.removeprefix(f'MSG: {PACKAGE}/'), body)}")
    return SEPARATOR.join(parts)


@cache
def type_hash(kind: str) -> str:
    """RIHS01 hash of a message, as rosidl computes it."""
    return typestore().hash_rihs01(full_name(kind))


def serialise(kind: str, fields: Mapping[str, Any]) -> bytes:
    """CDR of a message from plain fields: numbers, text, contiguous arrays, and mappings for messages inside."""
    name = full_name(kind)
    return bytes(typestore().serialize_cdr(_message(name, fields), name))


def deserialise(kind: str, data: bytes | memoryview) -> Any:
    """Message with its fields as attributes; raises rosbags' SerdeError for data that are not such a message."""
    return typestore().deserialize_cdr(data, full_name(kind))


def stored_types(definition: bytes, name: str) -> dict[str, Any]:
    """Fields by types of a stored definition; raises ValueError for a text that is none, or is too long."""
    found = _stored_types(definition, name)
    if isinstance(found, str):
        raise ValueError(found)  # noqa: TRY004 - it says what is wrong with the text
    return found


@lru_cache(maxsize=64)
def _stored_types(definition: bytes, name: str) -> dict[str, Any] | str:
    """The same, or what is wrong: said once, for reading it again takes as long for every message."""
    if len(definition) > LARGEST:
        return f"its definition has {len(definition)} bytes, more than {LARGEST}"
    try:
        lines = [line for line in definition.decode().splitlines() if line.strip()]  # the parser is slow with others
        return dict(get_types_from_msg("\n".join([*lines, ""]), name))
    except (TypesysError, LookupError, ValueError, RuntimeError) as reason:
        return " ".join(str(reason)[:500].split())


@lru_cache(maxsize=64)
def decoder(kind: str, encoding: str, definition: bytes) -> Decode:
    """Function from CDR of a stored ``definition`` to a message of this version with its fields as attributes.

    Raises DefinitionError, or ValueError for a text that is no definition.
    """
    name = full_name(kind)
    if encoding != "ros2msg" or not definition.strip():
        return lambda data: deserialise(kind, data)
    stored, ours = stored_types(definition, name), typestore().fielddefs
    if all(stored.get(other) == tuple(ours[other]) for other in _within(name)):
        return lambda data: deserialise(kind, data)
    for other in _within(name):
        _check(other, dict(ours[other][1]), dict(stored[other][1]) if other in stored else {})
    theirs = get_typestore(Stores.EMPTY)
    theirs.register(stored)
    return lambda data: _conformed(name, theirs.deserialize_cdr(data, name))


def converter(kind: str, encoding: str, definition: bytes) -> Callable[[bytes], bytes]:
    """Function from CDR of a stored ``definition`` to CDR of this version; errors as of ``decoder``.

    The function raises rosbags' SerdeError for data that are not such a message.
    """
    decode = decoder(kind, encoding, definition)
    return lambda data: serialise(kind, _fields_of(decode(data)))


def _fields_of(message: Any) -> dict[str, Any]:
    """Plain fields of a message, and of the messages within it."""

    def plain(value: Any) -> Any:
        if isinstance(value, list):
            return [plain(each) for each in value]
        return _fields_of(value) if hasattr(value, "__dict__") else value

    return {name: plain(value) for name, value in vars(message).items()}


def _message(name: str, fields: Mapping[str, Any]) -> Any:
    """Message object of a type; a field that is missing or unknown raises TypeError."""
    values = dict(fields)
    for field, inner in _inner_types(name).items():
        value = values[field]
        values[field] = _message(inner, value) if isinstance(value, Mapping) else [_message(inner, v) for v in value]
    return typestore().types[name](**values)


@cache
def _inner_types(name: str) -> dict[str, str]:
    """Fields of a message that are messages or sequences of messages, with their types."""
    fields: list[tuple[str, Any]] = typestore().fielddefs[name][1]
    elements = [(field, of[1][0] if of[0] == Nodetype.SEQUENCE else of) for field, of in fields]
    return {field: of[1] for field, of in elements if of[0] == Nodetype.NAME}


def _of_package(name: str) -> dict[str, str]:
    """The same, if they are of the package."""
    return {field: inner for field, inner in _inner_types(name).items() if inner.startswith(f"{PACKAGE}/")}


def _within(name: str) -> list[str]:
    """A message of the package, and all messages of the package within it."""
    return [name, *(other for inner in _of_package(name).values() for other in _within(inner))]


def _check(name: str, ours: dict[str, Any], stored: dict[str, Any]) -> None:
    kind = name.rpartition("/")[2]
    for field, of in ours.items():
        if field not in stored and field not in DEFAULTS.get(kind, {}):
            raise DefinitionError(f"{kind} has no {field}")
        if field in stored and stored[field] != of:
            raise DefinitionError(f"{kind} has another type of {field}")


def _conformed(name: str, found: Any) -> Any:
    """A stored message with the fields of this version."""
    made, inner = SimpleNamespace(), _of_package(name)
    fields = [field for field, _ in typestore().fielddefs[name][1]]
    for field in [field for field in fields if hasattr(found, field)]:
        value = getattr(found, field)
        if field in inner:
            many = isinstance(value, list)
            value = [_conformed(inner[field], one) for one in value] if many else _conformed(inner[field], value)
        setattr(made, field, value)
    for field in [field for field in fields if not hasattr(found, field)]:
        setattr(made, field, DEFAULTS[name.rpartition("/")[2]][field](made))
    return made
