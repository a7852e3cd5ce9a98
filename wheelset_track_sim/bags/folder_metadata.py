"""``metadata.yaml`` of a bag folder, as ``ros2 bag`` writes and needs it."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.text_files import read_text
from ..inputs.yaml12 import dump, parse
from .topics import TYPE_HASH, Topic

METADATA = "metadata.yaml"
VERSION = 9
LARGEST = 100_000_000
"""Bytes of ``metadata.yaml`` that are read."""
MOST_FILES, LONGEST_NAME = 100_000, 1000


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
    try:
        temporary.write_text("\n".join([*lines, ""]), "utf-8")
        temporary.replace(folder / METADATA)
    finally:
        temporary.unlink(missing_ok=True)


def listed_files(folder: Path) -> list[str]:
    """Names of the files that ``metadata.yaml`` of a folder lists, in their order.

    Raises InputError, which says what is wrong with it, if it does not list them.
    """
    listed = _listed(read_text(folder / METADATA, LARGEST))
    if not isinstance(listed, list) or len(listed) > MOST_FILES:
        raise InputError(f"relative_file_paths is not a list of up to {MOST_FILES} files")
    for name in listed:
        if not isinstance(name, str) or not Path(name).name:
            raise InputError("relative_file_paths has an entry that is not a file name")
        if len(name) > LONGEST_NAME:
            raise InputError(
                f"relative_file_paths has a name of {len(name)} characters, and {LONGEST_NAME} are allowed"
            )
    return [Path(name).name for name in listed]  # the files of a bag are in its folder


def _listed(text: str) -> Any:
    """The list of files in ``metadata.yaml``, cut out if that is laid out as recorders do it, for YAML is slow."""
    files = re.search(r"(?m)^ *relative_file_paths:(?:\n *- .*)+", text)
    data = parse(textwrap.dedent(files[0]) if files else text, METADATA, trusted=False)
    while isinstance(data, dict) and data:
        data = data.get("rosbag2_bagfile_information", data.get("relative_file_paths"))
    return data


def _text(name: str) -> str:
    """A name as YAML, with any characters in it."""
    return json.dumps(name, ensure_ascii=False)
