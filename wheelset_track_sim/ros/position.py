"""Where the wheelset is, as standard messages: ``nav_msgs/Odometry`` and transforms; and the names of its frames.

Frames follow REP-103 and REP-105: ``map`` is fixed to the world, ``track`` lies on the rails where the run began, with
x in the running direction, and ``wheelset`` is in the middle of the axle. It moves along and does not roll.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ..bags.bag_writer import PREFIX
from ..bags.messages import FRAME
from ..bags.topics import DEPTH
from ..errors import InputError
from ..simulation.simulator import Simulator
from .conversions import header

MAP, WHEELSET = "map", "wheelset"
LONGEST_PREFIX = 200
"""Characters of a prefix at most."""
TF_DEPTH = 100
"""Transforms that are kept for a slow listener, as in tf2."""


@dataclass(frozen=True)
class Frames:
    """Names of the frames of one wheelset."""

    track: str = FRAME
    wheelset: str = WHEELSET

    @classmethod
    def of(cls, node: str, prefix: str) -> Frames:
        """Frames of a node by its full name, or by a prefix if that is not empty.

        A node of the default name has no prefix. Raises InputError for one that frames of tf cannot have.
        """
        if len(prefix) > LONGEST_PREFIX or not re.fullmatch(r"(\w[\w.-]*(/\w[\w.-]*)*)?", prefix, re.ASCII):
            raise InputError(
                f"frame_prefix = {prefix!r} is no name of a frame: give up to {LONGEST_PREFIX} letters, digits, _, . "
                "and -, in parts with a slash between them, and none at its ends"
            )
        own = "" if node == PREFIX else node.strip("/")
        begin = prefix or own
        return cls(*(f"{begin}/{name}".lstrip("/") for name in (FRAME, WHEELSET)))


@dataclass(frozen=True)
class Motion:
    """Motion of the wheelset at a step, in the frame of the track; SI units."""

    time: float
    """Since step 0."""
    x: float
    y: float
    z: float
    """Of the middle of the axle."""
    speed: float
    acceleration: float
    radius: float

    @property
    def angle(self) -> float:
        """By which it has rolled about y since step 0, rad, from 0 to below 2 pi."""
        return math.fmod(self.x / self.radius, 2 * math.pi)

    @classmethod
    def at(cls, simulator: Simulator, step: int) -> Motion:
        """Motion at a step of the latest block, or at its end."""
        scenario, on = simulator.in_force, simulator.course.at(step)
        dx = scenario.step_length
        ramp = scenario.acceleration * ((on.set_point > on.speed) - (on.set_point < on.speed))
        radius = scenario.wheelset.rolling_radius
        return cls(on.time_of(step, dx), step * dx, scenario.lateral_offset, radius, on.speed, ramp, radius)


class PositionTopics:
    """``~/odometry`` and transforms of one node, once a chunk, as far as parameters ask for them."""

    def __init__(self, node: Any, frames: Frames, *, odometry: bool, tf: bool) -> None:
        """For ``node``; raises InputError if the package of a message that is asked for is not installed."""
        self._node, self._frames = node, frames
        self._odometry = _package("publish_odometry", "nav_msgs") if odometry else None
        self._tf = _package("publish_tf", "tf2_msgs") if tf else None
        self._publish: list[Callable[[Motion, int], None]] = []
        self._publishers: list[Any] = []

    def create(self) -> None:
        """Make the publishers."""
        if self._odometry is not None:
            self._moving = self._made(self._odometry.Odometry, "~/odometry", QoSProfile(depth=DEPTH))
            self._publish.append(self._publish_odometry)
        if self._tf is not None:
            self._transforms = self._made(self._tf.TFMessage, "/tf", QoSProfile(depth=TF_DEPTH))
            latched = QoSProfile(
                depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
            )
            static = self._made(self._tf.TFMessage, "/tf_static", latched)
            fixed = self._transform(self._node.get_clock().now().to_msg(), MAP, self._frames.track)
            static.publish(self._tf.TFMessage(transforms=[fixed]))
            self._publish.append(self._publish_transform)

    def publish(self, motion: Motion, start_ns: int) -> None:
        """Publish where the wheelset is; ``start_ns`` is the time stamp of step 0, ns."""
        for publish in self._publish:
            publish(motion, start_ns)

    def destroy(self) -> None:
        """Take the publishers away."""
        self._publish.clear()
        while self._publishers:
            self._node.destroy_publisher(self._publishers.pop())

    def _made(self, kind: Any, topic: str, quality: QoSProfile) -> Any:
        publisher = self._node.create_publisher(kind, topic, quality)
        self._publishers.append(publisher)
        return publisher

    def _publish_odometry(self, motion: Motion, start_ns: int) -> None:
        assert self._odometry is not None
        message = self._odometry.Odometry(child_frame_id=self._frames.wheelset)
        message.header = header(motion.time, start_ns, self._frames.track)
        at = message.pose.pose.position
        at.x, at.y, at.z = motion.x, motion.y, motion.z
        message.twist.twist.linear.x = motion.speed
        self._moving.publish(message)

    def _publish_transform(self, motion: Motion, start_ns: int) -> None:
        assert self._tf is not None
        stamp = header(motion.time, start_ns).stamp
        moved = self._transform(stamp, self._frames.track, self._frames.wheelset)
        at = moved.transform.translation
        at.x, at.y, at.z = motion.x, motion.y, motion.z
        self._transforms.publish(self._tf.TFMessage(transforms=[moved]))

    def _transform(self, stamp: Any, parent: str, child: str) -> Any:
        found = import_module("geometry_msgs.msg").TransformStamped(child_frame_id=child)
        found.header.stamp, found.header.frame_id = stamp, parent
        return found


def _package(parameter: str, package: str) -> Any:
    try:
        return import_module(f"{package}.msg")
    except ModuleNotFoundError:
        raise InputError(
            f"{parameter} = true needs {package}, which is not installed: install it, or set false"
        ) from None
