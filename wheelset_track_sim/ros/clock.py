"""Time of the node: what paces its run, where its stamps begin, and ``/clock`` if the node publishes it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.clock import ClockChange, JumpThreshold, TimeJump
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

TOPIC = "/clock"
ANY_CHANGE = JumpThreshold(min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1))
"""With this every message on ``/clock`` is a jump; the clock of the machine never jumps."""


class NodeClock:
    """The machine's elapsed time, or with ``use_sim_time`` the time on ``/clock``, which may stop and be set back.

    Nothing polls: who sleeps is woken by each message on ``/clock``.
    """

    def __init__(self, node: Node, *, publish: bool) -> None:
        """Of ``node``, as long as it lives; with ``publish`` it publishes the time on ``/clock``."""
        self._node, self._clock = node, node.get_clock()
        self._log = node.get_logger()
        self._sleeping: set[threading.Event] = set()
        self.epoch = 0
        """Another number each time the clock is set anew."""
        self._publisher: Any = None
        if publish:
            quality = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.RELIABLE)
            self._publisher = node.create_publisher(Clock, TOPIC, quality)
        self._handle = self._clock.create_jump_callback(ANY_CHANGE, post_callback=self._jumped)

    @property
    def following(self) -> bool:
        """Whether the time is that on ``/clock``."""
        return bool(self._clock.ros_time_is_active)

    def now_ns(self) -> int:
        """Time for stamps, ns; 0 before the first message on ``/clock``."""
        return int(self._clock.now().nanoseconds)

    def now(self) -> float:
        """Time to be paced by, s."""
        return self.now_ns() * 1e-9 if self.following else time.monotonic()

    def sleep(self, due: float, wake: threading.Event) -> None:
        """Return when it is ``due``, when ``wake`` is set, or earlier."""
        self._sleeping.add(wake)
        try:
            if self.following:
                if self.now() < due:
                    wake.wait()
            else:
                wake.wait(max(0.0, due - self.now()))
        finally:
            self._sleeping.discard(wake)

    def wait_for_time(self, given_up: Callable[[], bool]) -> None:
        """Return when there is a time, or when it is ``given_up``, which is asked again after ``wake``."""
        wake = threading.Event()
        self._sleeping.add(wake)
        while self.now_ns() == 0 and not given_up():
            wake.wait()
            wake.clear()
        self._sleeping.discard(wake)

    def wake(self) -> None:
        """Wake all who sleep."""
        for wake in tuple(self._sleeping):
            wake.set()

    def warn_of_others(self) -> None:
        """Log if the node is not the only one that publishes the time."""
        if self._publisher is not None:
            others = self._node.count_publishers(self._publisher.topic_name) - 1
            if others > 0:
                self._log.warning(f"{others} more publish on {TOPIC}: let one do it")

    def tell(self, now_ns: int) -> None:
        """Publish a time, if the node is to publish it."""
        if self._publisher is not None:
            seconds, nanoseconds = divmod(now_ns, 10**9)
            self._publisher.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))

    def _jumped(self, jump: TimeJump) -> None:
        forward = jump.delta.nanoseconds
        if jump.clock_change != ClockChange.ROS_TIME_NO_CHANGE or forward < 0 or forward == self.now_ns():
            self.epoch += 1  # another clock, one that was set back, or the first message
        if forward < 0:
            self._log.warning(f"{TOPIC} was set back by {-forward * 1e-9:g} s: the run continues from where it is")
        self.wake()
