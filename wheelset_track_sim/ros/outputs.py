"""Topics that the node publishes, relative to its name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from ..recording.messages import Message, stress_topic
from ..recording.rosbag2_metadata import DEPTH, LATCHED_TOPICS
from .conversions import message_type


class Outputs:
    """Publishers of one run: ``contact_forces``, ``axle_stress/*``, ``summary``, and ``state`` for late subscribers."""

    def __init__(self, node: Node) -> None:
        """For ``node``; nothing is published before ``create``."""
        self._node = node
        self._publishers: dict[str, Any] = {}

    def create(self, stress_nodes: Sequence[str]) -> None:
        """Make the publishers; those of the stream publish while the node is active."""
        kinds = {"contact_forces": "ContactForces", "summary": "LoadSummary", "state": "SimulationState"}
        kinds |= {stress_topic(name): "AxleStress" for name in stress_nodes}
        for topic, kind in kinds.items():
            latched = topic in LATCHED_TOPICS
            quality = QoSProfile(
                history=HistoryPolicy.KEEP_LAST,
                depth=1 if latched else DEPTH,
                reliability=ReliabilityPolicy.RELIABLE,
                durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
            )
            # The state is told while the node is inactive too.
            make = self._node.create_publisher if latched else self._node.create_lifecycle_publisher
            self._publishers[topic] = make(message_type(kind), f"~/{topic}", quality)

    def publish(self, messages: Iterable[Message]) -> None:
        """Publish messages on their topics."""
        for message in messages:
            self._publishers[message.topic].publish(message.cdr)

    def destroy(self) -> None:
        """Take the publishers away."""
        for topic, publisher in self._publishers.items():
            if topic in LATCHED_TOPICS:
                self._node.destroy_publisher(publisher)
            else:
                self._node.destroy_lifecycle_publisher(publisher)
        self._publishers.clear()
