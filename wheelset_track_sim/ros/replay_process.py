"""The process of the replay node."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from rclpy.executors import SingleThreadedExecutor

from ..errors import InputError
from .hosting import Ending, next_ending, own_arguments, session, spinning
from .replay import ReplayNode

FAREWELL = 1.0
"""Time for who asked last, such as for ``stop``, to take the answer, s: what is not taken goes with its sender."""


def main(arguments: Sequence[str], given: Mapping[str, Any]) -> int:
    """Play a bag until it ends, or a signal comes; ``given`` are parameters above those of ROS in ``arguments``.

    Returns 0; raises InputError for arguments or parameters that cannot be used, WheelsetTrackError for the bag.
    """
    own = own_arguments(arguments)
    if own:
        raise InputError(f"{own[0]} is not an argument of the replay: see wheelset-track-sim replay --help")
    with session(arguments) as endings, ExitStack() as stack:
        node = ReplayNode(lambda failure: endings.put(Ending(0, failure)), given)
        stack.callback(node.destroy_node)
        executor = SingleThreadedExecutor()
        stack.callback(executor.shutdown)
        executor.add_node(node)
        with spinning(executor):
            try:
                node.begin()
                by, failure = next_ending(endings)
                if by is not None:
                    time.sleep(FAREWELL)
            finally:
                node.close()
    if failure is not None:
        raise failure
    return 0
