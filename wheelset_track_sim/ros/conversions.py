"""From what the package says to messages of ROS; those of this project go as the bytes that bags hold."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import wheelset_track_msgs.msg
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..bags.messages import FRAME, NANOSECOND
from ..monitoring.status import Status


def message_type(kind: str) -> Any:
    """Class of a message of this project by its short name, such as ``AxleStress``."""
    return getattr(wheelset_track_msgs.msg, kind)


def header(time: float, start_ns: int, frame: str = FRAME) -> Any:
    """Header of what happens at a simulated ``time``, s; ``start_ns`` is the time stamp of step 0, ns."""
    seconds, nanoseconds = divmod(start_ns + round(time / NANOSECOND), 10**9)
    return Header(stamp=Time(sec=seconds, nanosec=nanoseconds), frame_id=frame)


def diagnostics(statuses: Iterable[Status], node: str, stamp: Any) -> Any:
    """DiagnosticArray of the subjects of a node, each called ``NODE: SUBJECT`` as diagnostic_updater does."""
    array = DiagnosticArray()
    array.header.stamp = stamp
    array.status = [
        DiagnosticStatus(
            level=bytes([status.level]),
            name=f"{node}: {status.name}",
            message=status.message,
            hardware_id=node,
            values=[KeyValue(key=key, value=value) for key, value in status.values],
        )
        for status in statuses
    ]
    return array
