"""What ``ros2 bag`` wants beside the messages: quality of service of a topic, ``metadata.yaml`` of a folder."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import dump, parse
from .definitions import full_name, type_hash

METADATA = "metadata.yaml"
PROFILES, TYPE_HASH = "offered_qos_profiles", "topic_type_hash"
VERSION = 9
FOREVER = {"sec": 9223372036, "nsec": 854775807}
LATCHED_TOPICS = {"state"}
"""Topics that a late subscriber gets the last message of (transient local)."""
DEPTH = 50
"""Messages of a topic kept for a slow subscriber."""


@dataclass(frozen=True)
class Topic:
    """One topic of a bag."""

    name: str
    type: str
    """Full name of its type."""
    metadata: Mapping[str, str]
    """Of its MCAP channel: offered quality of service as YAML, hash of its type."""

    @classmethod
    def of(cls, name: str, kind: str, latched: bool) -> Topic:
        """Topic of a message of this package."""
        return cls(name, full_name(kind), {PROFILES: _profiles(latched), TYPE_HASH: type_hash(kind)})


@dataclass(frozen=True)
class Part:
    """One file of a bag: the time stamps of its messages, ns, their number by topic, its size in bytes."""

    name: str
    first_ns: int
    last_ns: int
    counts: Mapping[str, int]
    size: int

    @property
    def count(self) -> int:
        """Number of all messages."""
        return sum(self.counts.values())


def quality_of_service(latched: bool) -> list[dict[str, Any]]:
    """Offered profiles of a topic; rosbag2 wants every field, in lower case."""
    return [
        {
            "history": "keep_last",
            "depth": 1 if latched else DEPTH,
            "reliability": "reliable",
            "durability": "transient_local" if latched else "volatile",
            "deadline": dict(FOREVER),
            "lifespan": dict(FOREVER),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(FOREVER),
            "avoid_ros_namespace_conventions": False,
        }
    ]


@cache
def _profiles(latched: bool) -> str:  # YAML takes 6 ms a topic
    return dump(quality_of_service(latched)).strip()


@cache
def _parsed_profiles(text: str) -> Any:
    try:
        return parse(text, PROFILES) or []
    except InputError:  # of another recorder
        return []


def write_folder_metadata(folder: Path, parts: Sequence[Part], topics: Sequence[Topic]) -> None:
    """Write ``metadata.yaml`` of a bag folder with its files; the old one stays until the new one is complete."""
    told = [part for part in parts if part.count] or parts[:1]
    first_ns, last_ns = min(part.first_ns for part in told), max(part.last_ns for part in told)
    head = {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": {"nanoseconds": last_ns - first_ns},
        "starting_time": {"nanoseconds_since_epoch": first_ns},
        "message_count": sum(part.count for part in parts),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": _parsed_profiles(topic.metadata.get(PROFILES, "")),
                    "type_description_hash": topic.metadata.get(TYPE_HASH, ""),
                },
                "message_count": sum(part.counts.get(topic.name, 0) for part in parts),
            }
            for topic in topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "custom_data": None,
        "ros_distro": "jazzy",
    }
    # Line by line, as long bags of many files are told at each new one: a library takes a second for a thousand.
    lines = dump({"rosbag2_bagfile_information": head}).splitlines()
    lines += ["  relative_file_paths:", *(f"  - {_text(part.name)}" for part in parts), "  files:"]
    for part in parts:
        lines += [
            f"  - path: {_text(part.name)}",
            f"    starting_time: {{nanoseconds_since_epoch: {part.first_ns}}}",
            f"    duration: {{nanoseconds: {part.last_ns - part.first_ns}}}",
            f"    message_count: {part.count}",
        ]
    temporary = folder / f"{METADATA}.tmp"
    temporary.write_text("\n".join([*lines, ""]), "utf-8")
    temporary.replace(folder / METADATA)


def _text(name: str) -> str:
    """A name as YAML, whatever is in it."""
    return json.dumps(name, ensure_ascii=False)
