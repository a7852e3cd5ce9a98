"""``metadata.yaml`` of a bag folder, as ``ros2 bag`` writes and needs it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import dump, parse
from .losses import Damage
from .topics import TYPE_HASH, Topic

METADATA = "metadata.yaml"
VERSION = 9


@dataclass(frozen=True)
class BagPart:
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


def write_folder_metadata(folder: Path, parts: Sequence[BagPart], topics: Sequence[Topic]) -> None:
    """Write ``metadata.yaml`` of a bag folder with its files; the old one is replaced when the new one is complete."""
    filled = [part for part in parts if part.count] or parts[:1]
    first_ns, last_ns = min(part.first_ns for part in filled), max(part.last_ns for part in filled)
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
                    "offered_qos_profiles": topic.profiles,
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
    # Line by line, because this is written again with each new file: a library takes a second for a thousand files.
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


def missing_files(folder: Path) -> list[Damage]:
    """Files that ``metadata.yaml`` of a folder lists and that are not there; that file itself, too."""
    text = folder / METADATA
    if not text.exists():
        return [Damage(METADATA, 0, 0, "it is missing")]
    try:
        names = [str(name) for name in _listed(text.read_text("utf-8"))["relative_file_paths"]]
    except (OSError, InputError, ValueError, LookupError, TypeError):
        return [Damage(METADATA, 0, 0, "it cannot be read")]
    return [Damage(name, 0, 0, "it is missing") for name in names if not (folder / name).exists()]


def _listed(text: str) -> Any:
    """What ``metadata.yaml`` says; only its list of files if that is laid out as recorders do it, for YAML is slow."""
    files = re.search(r"(?m)^ *relative_file_paths:(?:\n *- .*)+", text)
    return parse(files[0].strip(), METADATA) if files else parse(text, METADATA)["rosbag2_bagfile_information"]


def _text(name: str) -> str:
    """A name as YAML, with any characters in it."""
    return json.dumps(name, ensure_ascii=False)
