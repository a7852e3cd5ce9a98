"""The message definitions of ``wheelset_track_msgs`` without ROS: schema texts, type hashes, CDR."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

PACKAGE = "wheelset_track_msgs"
SEPARATOR = "=" * 80 + "\n"


def full_name(kind: str) -> str:
    """Full type name of a message of the package, such as ``wheelset_track_msgs/msg/AxleStress``."""
    return f"{PACKAGE}/msg/{kind}"


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
    """The ``ros2msg`` schema of a message: its definition, then those of all that it holds."""
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


def _message(name: str, fields: Mapping[str, Any]) -> Any:
    """Message object of a type; a field that is missing or unknown raises TypeError."""
    values = dict(fields)
    for field, inner in _inner_types(name):
        value = values[field]
        values[field] = _message(inner, value) if isinstance(value, Mapping) else [_message(inner, v) for v in value]
    return typestore().types[name](**values)


@cache
def _inner_types(name: str) -> list[tuple[str, str]]:
    """Fields of a message that are messages or sequences of messages, with their types."""
    fields: list[tuple[str, Any]] = typestore().fielddefs[name][1]
    elements = [(field, of[1][0] if of[0] == Nodetype.SEQUENCE else of) for field, of in fields]
    return [(field, of[1]) for field, of in elements if of[0] == Nodetype.NAME]
