"""What a bag says of its topics: types, definitions, qualities of service."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mcap.records import Channel, Schema
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

from ...errors import InputError
from ...inputs.yaml12 import parse
from ..definitions import PACKAGE, typestore
from ..rosbag2_metadata import DEPTH

HEADER = (Nodetype.NAME, "std_msgs/msg/Header")
CLOCK = "/clock"
LATCHED_KIND = f"{PACKAGE}/msg/SimulationState"
RELIABLE, TRANSIENT_LOCAL, KEEP_LAST = ("reliable", 1), ("transient_local", 1), ("keep_last", 1)
"""Words of rosbag2 since version 9 of its metadata, and its numbers before."""
OURS = ("contact_forces", "axle_stress/", "summary", "impacts", "state")
"""Topics of the node, relative to its name; the second is the beginning of some."""


@dataclass(frozen=True)
class Topic:
    """A topic as it was recorded."""

    name: str
    kind: str
    """Full name of the type."""
    encoding: str
    """Of the definition."""
    definition: str
    reliable: bool
    latched: bool
    """Whether a late subscriber is told the last message (transient local)."""
    depth: int
    """Messages kept for a slow subscriber."""

    @classmethod
    def of(cls, channel: Channel, schema: Schema) -> Topic:
        """From what a bag says; a quality that it does not tell is that of the node."""
        offered = _offered(channel.metadata.get("offered_qos_profiles", ""))
        latched = offered["durability"] in TRANSIENT_LOCAL if "durability" in offered else schema.name == LATCHED_KIND
        depth = offered.get("depth") if offered.get("history") in KEEP_LAST else None
        return cls(
            name=channel.topic,
            kind=schema.name,
            encoding=schema.encoding,
            definition=schema.data.decode(errors="replace"),
            reliable=offered.get("reliability", "reliable") in RELIABLE,
            latched=latched,
            depth=depth if isinstance(depth, int) and depth > 0 else 1 if latched else DEPTH,
        )

    @property
    def ours(self) -> bool:
        """Whether it is of the messages of this project."""
        return self.kind.startswith(f"{PACKAGE}/")

    @property
    def prefix(self) -> str | None:
        """Name of the node with its namespace that comes before the topics of a run; None for other topics."""
        if not self.ours:
            return None
        for name in OURS:
            before, found, after = self.name.rpartition(f"/{name}")
            if found and (name.endswith("/") or not after):
                return before
        return None

    @property
    def stamped(self) -> bool:
        """Whether its messages begin with a header."""
        fields = self._recorded.get(self.kind) or typestore().fielddefs.get(self.kind) or ([], [])
        return bool(fields[1]) and fields[1][0][1] == HEADER

    @property
    def outdated(self) -> bool:
        """Whether its type is defined otherwise here: its bytes would be taken for something else."""
        known = typestore()
        if self.kind not in self._recorded or self.kind not in known.fielddefs:
            return False
        try:
            store = get_typestore(Stores.EMPTY)
            store.register(self._recorded)
            return bool(store.hash_rihs01(self.kind) != known.hash_rihs01(self.kind))
        except (TypesysError, LookupError):  # a definition that lacks those of its parts
            return False

    @cached_property
    def _recorded(self) -> dict[str, Any]:
        """Fields by types, from the recorded definition; empty if that is of another kind."""
        if self.encoding != "ros2msg":
            return {}
        try:
            return dict(get_types_from_msg(self.definition, self.kind))
        except TypesysError:
            return {}


def _offered(text: str) -> dict[str, Any]:
    """The first profile that publishers offered; empty if the bag does not say."""
    try:
        profiles = parse(text, "offered_qos_profiles") if text else []
    except InputError:
        return {}
    first = profiles[0] if isinstance(profiles, list) and profiles else {}
    return first if isinstance(first, dict) else {}
