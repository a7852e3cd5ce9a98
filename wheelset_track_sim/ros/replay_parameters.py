"""Parameters of the replay node."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

from rclpy.node import Node

from ..bags.topics import Topic
from ..errors import InputError
from ..inputs.schema import quantity_of
from ..live.player import Playback
from .declaring import declare, fixed, flag, number, warn_of_unknown
from .replay_start import Start

START_UP = {
    "bag": ("", "Bag folder or .mcap file"),
    "stamps": (
        "original",
        "Stamps of the messages: original, or now, which start at the current time",
    ),
    "prefix": (
        "",
        "Name of the node that topics get instead of the recorded one; ~ is this node's, empty: as recorded",
    ),
    "publish_clock": (False, "Publish the time of the replay on /clock, for nodes with use_sim_time"),
    "start_paused": (False, "Wait until the service resume is called"),
}
STAMPS = ("original", "now")
POSITION = dataclasses.replace(quantity_of(Playback, "start_offset"), meaning="the time in the bag, set to seek there")
FIXED = ("start_offset", "duration")
BEFORE = ("delay", "wait")


class ReplayParameters:
    """The parameters that a replay node declares, and what they describe."""

    def __init__(self, node: Node) -> None:
        """Declare all parameters of ``node``; raises InputError if one given at the start cannot be used."""
        self._node = node
        for name, (default, description) in START_UP.items():
            declare(node, name, default, fixed(description))
        for name in ("rate", *FIXED):
            declare(node, name, getattr(Playback, name), number(quantity_of(Playback, name), read_only=name in FIXED))
        for name in BEFORE:
            declare(node, name, getattr(Start, name), number(quantity_of(Start, name), read_only=True))
        declare(node, "position", self["start_offset"], number(POSITION))
        declare(node, "loop", False, flag("Begin again at the end"))
        warn_of_unknown(node)
        if not self["bag"]:
            raise InputError("bag is missing: give a bag folder or an .mcap file")
        if self["stamps"] not in STAMPS:
            raise InputError(f"stamps = {self['stamps']} is not known: give one of {', '.join(STAMPS)}")
        if self["use_sim_time"] and self["publish_clock"]:
            raise InputError(
                "use_sim_time and publish_clock cannot both be true: "
                "a node cannot follow the clock that it publishes, set one of them to false"
            )

    def __getitem__(self, name: str) -> Any:
        """Value of a parameter."""
        return self._node.get_parameter(name).value

    def playback(self) -> Playback:
        """What is to be played, and how."""
        return Playback(**{field.name: self[field.name] for field in dataclasses.fields(Playback)})

    def start(self) -> Start:
        """When it begins."""
        return Start(**{name: self[name] for name in BEFORE})

    def renamed(self, topic: Topic, recorded: Iterable[Topic]) -> str:
        """Name under which a topic is published; InputError if ``recorded`` are of several nodes, and one is named."""
        wanted: str = self["prefix"].rstrip("/")
        if not wanted:
            return topic.name
        before = {other.prefix for other in recorded if other.prefix is not None}
        if len(before) > 1:
            raise InputError(
                f"prefix = {wanted} replaces the name of one node, but the bag has {', '.join(sorted(before))}: "
                "rename topics by --ros-args -r FROM:=TO"
            )
        inside = [name for name in before if topic.name.startswith(f"{name}/")]
        return wanted + topic.name.removeprefix(inside[0]) if inside else topic.name
