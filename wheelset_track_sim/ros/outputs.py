"""Topics that the node publishes, relative to its name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from ..bags.messages import FATIGUE, FRAME, SENSORS, Message, in_frame, sample_messages, stress_topic
from ..bags.topics import DEPTH, LATCHED_TOPICS
from ..samples.block import SampleBlock
from ..samples.decimation import BlockDecimator
from ..sensors.acquisition import TRUE
from ..sensors.kinds import Sensor
from ..wayside.detector import WaysideDetector
from .acknowledged import wait_for_subscribers
from .conversions import message_type
from .position import Motion, PositionTopics


class Outputs:
    """Publishers of one run: ``contact_forces``, ``axle_stress/*``, ``summary``, ``impacts``, and a latched ``state``.

    Those of sensors and of detectors beside the track follow. Forces and stresses may be decimated, each by a factor of
    its own; the summary is always of every step. True values of sensors are recorded and not published.
    """

    def __init__(
        self, node: Node, decimation: Mapping[str, int], frame: str = FRAME, position: PositionTopics | None = None
    ) -> None:
        """For ``node``; nothing is published before ``create``. ``frame`` is that of all headers."""
        self._frame, self._position = frame, position
        self.decimation = decimation
        """Steps from sample to sample by topic, from the next chunk on; a filter that changes starts anew."""
        self._node = node
        self._publishers: dict[str, Any] = {}
        self._decimators: dict[str, BlockDecimator] = {}
        self._start_ns = 0

    def create(
        self,
        stress_nodes: Sequence[str],
        sensors: Sequence[Sensor] = (),
        wayside: Sequence[WaysideDetector] = (),
        *,
        fatigue: bool = False,
    ) -> None:
        """Make the publishers; those of the stream publish while the node is active."""
        kinds = {"contact_forces": "ContactForces", "summary": "LoadSummary"}
        kinds |= {"impacts": "WheelImpact", "state": "SimulationState"}
        kinds |= {stress_topic(name): "AxleStress" for name in stress_nodes}
        kinds |= {sensor.topic: sensor.kind for sensor in sensors}
        kinds |= {SENSORS: "SensorSummary"} if sensors else {}
        kinds |= {detector.topic: "WaysideReading" for detector in wayside}
        kinds |= {FATIGUE: "Fatigue"} if fatigue else {}
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
        if self._position is not None:
            self._position.create()

    def publish_chunk(self, block: SampleBlock, messages: Iterable[Message], start_ns: int) -> None:
        """Publish a chunk, whose ``messages`` are at full rate; ``start_ns`` is the time stamp of step 0, ns."""
        self._start_ns = start_ns
        for topic, factor in self.decimation.items():
            if self._factor(topic) != factor:
                self._finish(topic)
                if factor > 1:
                    self._decimators[topic] = BlockDecimator(factor)
        self.publish(message for message in messages if self._factor(_family(message)) == 1)
        for topic, decimator in self._decimators.items():
            needed = _forces_of(block) if topic == "contact_forces" else block
            self._publish_decimated(topic, decimator.push(needed))

    def publish_position(self, motion: Motion, start_ns: int) -> None:
        """Publish where the wheelset is, if that is asked for."""
        if self._position is not None:
            self._position.publish(motion, start_ns)

    def finish(self) -> None:
        """Publish what the filters hold back, at the end of a run."""
        for topic in [*self._decimators]:
            self._finish(topic)

    def publish(self, messages: Iterable[Message]) -> None:
        """Publish messages on their topics."""
        for message in messages:
            if message.topic.rpartition("/")[2] != TRUE:
                self._publishers[message.topic].publish(message.cdr)

    def destroy(self) -> None:
        """Take the publishers away, when what they sent has arrived."""
        wait_for_subscribers(self._publishers.values())
        for topic, publisher in self._publishers.items():
            if topic in LATCHED_TOPICS:
                self._node.destroy_publisher(publisher)
            else:
                self._node.destroy_lifecycle_publisher(publisher)
        self._publishers.clear()
        if self._position is not None:
            self._position.destroy()

    def _factor(self, topic: str) -> int:
        return self._decimators[topic].factor if topic in self._decimators else 1

    def _finish(self, topic: str) -> None:
        if topic in self._decimators:
            self._publish_decimated(topic, self._decimators.pop(topic).finish())

    def _publish_decimated(self, topic: str, blocks: Iterable[SampleBlock]) -> None:
        for block in blocks:
            messages = in_frame(sample_messages(block, self._start_ns), self._frame)
            self.publish(message for message in messages if _family(message) == topic)


def _forces_of(block: SampleBlock) -> SampleBlock:
    """The same block without stresses, which cost most of a filter's time."""
    return replace(block, stresses=block.stresses[:, :0], nodes=())


def _family(message: Message) -> str:
    """What a decimation is set for: ``axle_stress`` of ``axle_stress/a1``."""
    return message.topic.partition("/")[0]
