"""Topics of a bag: types, definitions, qualities of service."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_typestore

from ..errors import InputError
from ..inputs.yaml12 import dump, parse
from .definitions import converter, full_name, schema, stored_types, type_hash, typestore

PROFILES, TYPE_HASH = "offered_qos_profiles", "topic_type_hash"
FOREVER = {"sec": 9223372036, "nsec": 854775807}
LATCHED_TOPICS = {"state"}
"""Topics of the node whose last message a late subscriber receives (transient local)."""
DEPTH = 50
"""Messages of a topic kept for a slow subscriber."""
LARGEST_PROFILES = 100_000
"""Characters of the qualities of a topic that are read."""
DEEPEST = 10_000
"""The same at most, whatever a bag says."""
HEADER = (Nodetype.NAME, "std_msgs/msg/Header")
LATCHED_KIND = "SimulationState"
RELIABLE, TRANSIENT_LOCAL, KEEP_LAST = ("reliable", 1), ("transient_local", 1), ("keep_last", 1)
"""Words of rosbag2 since version 9 of its metadata, and its numbers before."""
UNREADABLE = (TypesysError, LookupError, ValueError, RecursionError)
"""Errors for definitions that are none."""
OF_NODE = (
    *("contact_forces", "axle_stress/", "summary", "impacts", "state", "fatigue"),
    *("axle_box_acceleration", "axle_box_acceleration/", "suspension_force", "suspension_force/", "sensor_summary"),
    *("strain/", "acceleration/", "velocity/", "displacement/", "wayside/"),
)
"""Topics of the node, relative to its name; a slash at the end marks the beginning of several."""


@dataclass(frozen=True)
class Topic:
    """A topic as channel and schema of an MCAP file describe it; a quality that a bag lacks is as in the node."""

    name: str
    type: str
    """Full name of its type."""
    kind: str
    """Short name of its type, if that is one of this package; otherwise empty."""
    definition: bytes
    metadata: Mapping[str, str] = field(compare=False)
    """Of the channel: offered quality of service as YAML, hash of the type."""
    encoding: str = "ros2msg"
    """Of the definition."""
    message_encoding: str = "cdr"

    @property
    def profiles(self) -> list[Any]:
        """Qualities of service that its publishers offered."""
        return _parsed_profiles(self.metadata.get(PROFILES, ""))

    @property
    def reliable(self) -> bool:
        """Whether messages are sent again until they arrive."""
        return self._offered.get("reliability", "reliable") in RELIABLE

    @property
    def latched(self) -> bool:
        """Whether a late subscriber receives the last message (transient local)."""
        offered = self._offered
        return offered["durability"] in TRANSIENT_LOCAL if "durability" in offered else self.kind == LATCHED_KIND

    @property
    def depth(self) -> int:
        """Messages kept for a slow subscriber."""
        depth = self._offered.get("depth") if self._offered.get("history") in KEEP_LAST else None
        if type(depth) is int and depth > 0:
            return min(depth, DEEPEST)
        return 1 if self.latched else DEPTH

    @property
    def prefix(self) -> str | None:
        """Name of the node, with its namespace, before a topic of a run; None for other topics."""
        for name in OF_NODE if self.kind else ():
            before, found, after = self.name.rpartition(f"/{name}")
            if found and (name.endswith("/") or not after):
                return before
        return None

    @cached_property
    def stamped(self) -> bool:
        """Whether its messages begin with a header."""
        fields = self._recorded.get(self.type) or typestore().fielddefs.get(self.type) or ([], [])
        return bool(fields[1]) and fields[1][0][1] == HEADER

    @cached_property
    def conversion(self) -> Callable[[bytes], bytes] | None:
        """From recorded bytes to those of this version's type; None if it is the same type, or another altogether."""
        if not (self.kind and self._differs):
            return None
        try:
            return converter(self.kind, self.encoding, self.definition)
        except (ValueError, LookupError, TypesysError):
            return None

    @property
    def outdated(self) -> bool:
        """Whether its type has another definition here, so that its bytes would be misread and cannot be converted."""
        return self._differs and self.conversion is None

    @cached_property
    def _differs(self) -> bool:
        """Whether its type has another definition here."""
        known = typestore()
        if self.type not in self._recorded or self.type not in known.fielddefs:
            return False
        try:
            store = get_typestore(Stores.EMPTY)
            store.register(self._recorded)
            return bool(store.hash_rihs01(self.type) != known.hash_rihs01(self.type))
        except UNREADABLE:  # a definition whose parts are missing
            return False

    @property
    def _offered(self) -> dict[str, Any]:
        first = self.profiles[0] if self.profiles else {}
        return first if isinstance(first, dict) else {}

    @cached_property
    def _recorded(self) -> dict[str, Any]:
        """Fields by types, from the recorded definition; empty if that has another encoding."""
        if self.encoding != "ros2msg":
            return {}
        try:
            return stored_types(self.definition, self.type)
        except ValueError:
            return {}


@cache
def topic_of_node(prefix: str, name: str, kind: str) -> Topic:
    """Topic ``name`` of the node ``prefix``, with messages ``kind`` of this package."""
    profiles = dump(_profiles(latched=name in LATCHED_TOPICS)).strip()  # YAML takes 6 ms a topic
    metadata = {PROFILES: profiles, TYPE_HASH: type_hash(kind)}
    return Topic(f"{prefix}/{name}", full_name(kind), kind, schema(kind).encode(), metadata)


def _profiles(*, latched: bool) -> list[dict[str, Any]]:
    """Offered profiles of a topic; rosbag2 needs every field, in lower case."""
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
def _parsed_profiles(text: str) -> list[Any]:
    try:
        found = parse(text, PROFILES, trusted=False) if len(text) < LARGEST_PROFILES else []
    except InputError:  # of another recorder
        return []
    return found if isinstance(found, list) else []
