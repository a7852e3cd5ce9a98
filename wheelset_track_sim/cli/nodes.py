"""``node`` and ``replay``: the commands that need ROS 2."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import InputError


def node(arguments: Sequence[str]) -> int:
    """Run the ROS 2 node with the arguments of every node; returns the exit status."""
    with _needs_ros("the node"):
        from ..ros.process import main
    return main(arguments)


def replay(bag: Path | None, ros_arguments: Sequence[str], **given: Any) -> int:
    """Play a bag through the ROS 2 node of the replay; returns the exit status.

    ``given`` are parameters of the node; those that are None are left to ``ros_arguments`` and to their defaults.
    """
    with _needs_ros("replay"):
        from ..ros.replay import main
    parameters = {name: value for name, value in given.items() if value is not None}
    if bag is not None:
        parameters["bag"] = str(bag)
    return main(ros_arguments, parameters)


@contextmanager
def _needs_ros(command: str) -> Iterator[None]:
    """Around the import of a node: raises InputError in one line without ROS 2 or the built messages."""
    try:
        yield
    except ModuleNotFoundError as missing:
        if missing.name not in {"rclpy", "wheelset_track_msgs"}:
            raise
        raise InputError(
            f"{command} needs ROS 2 Jazzy, and {missing.name} is not there: run make setup, or source the installation"
        ) from None
