"""``replay``: play a bag on the topics on which it was recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .needs_ros import needs_ros


def replay(bag: Path | None, ros_arguments: Sequence[str], **given: Any) -> int:
    """Play a bag through the ROS 2 node; returns the exit status.

    ``given`` are parameters of the node, None for those that are left to ``ros_arguments`` and to their defaults.
    """
    with needs_ros("replay"):
        from ..ros.replay_process import main
    told = {name: value for name, value in given.items() if value is not None}
    if bag is not None:
        told["bag"] = str(bag)
    return main(ros_arguments, told)
