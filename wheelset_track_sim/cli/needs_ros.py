"""What needs ROS 2, on a machine without it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import InputError


@contextmanager
def needs_ros(who: str) -> Iterator[None]:
    """Around the import of a node: raises InputError in one line if ROS 2 or the built messages are not there."""
    try:
        yield
    except ModuleNotFoundError as missing:
        if missing.name not in {"rclpy", "wheelset_track_msgs"}:
            raise
        raise InputError(
            f"{who} needs ROS 2 Jazzy, and {missing.name} is not there: run make setup, or source the installation"
        ) from None
