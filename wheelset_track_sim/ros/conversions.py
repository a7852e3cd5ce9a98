"""From what the package says to messages of ROS; those of this project go as the bytes that bags hold."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import wheelset_track_msgs.msg
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from ..monitoring.status import Status


def message_type(kind: str) -> Any:
    """Class of a message of this project by its short name, such as ``AxleStress``."""
    return getattr(wheelset_track_msgs.msg, kind)


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
