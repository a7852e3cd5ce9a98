"""The process of the node: arguments, executor, signals, exit."""

from __future__ import annotations

import argparse
import signal
import threading
from collections.abc import Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from types import FrameType

import rclpy
from rclpy.exceptions import InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import MultiThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.signals import SignalHandlerOptions

from ..errors import InputError
from .node import SimulationNode


def main(arguments: Sequence[str]) -> int:
    """Run the node until it ends by itself or is told to by a signal; returns 0.

    Raises InputError for arguments or parameters that cannot be used, WheelsetTrackError if the run failed.
    """
    _initialise(arguments)
    ended: SimpleQueue[Exception | None] = SimpleQueue()  # its put is safe in a signal handler

    def stop(number: int, frame: FrameType | None) -> None:
        ended.put(None)

    handlers = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        failure = _run(ended)
    except (InvalidNodeNameException, InvalidNamespaceException) as refusal:
        raise InputError(" ".join(str(refusal).split())) from None
    finally:
        rclpy.try_shutdown()
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if failure is not None:
        raise failure
    return 0


def _run(ended: SimpleQueue[Exception | None]) -> Exception | None:
    """The node and its executor until something is put into ``ended``; returns that, or what befell the bag."""
    node = SimulationNode(ended.put)
    executor = MultiThreadedExecutor(num_threads=3)
    executor.add_node(node)
    done = threading.Event()

    def spin() -> None:
        while not done.is_set():
            executor.spin_once(timeout_sec=1.0)

    spinning = threading.Thread(target=spin, name="executor")
    spinning.start()
    try:
        if node.parameters["autostart"]:
            executor.create_task(node.autostart)
        failure = _first(ended)
    finally:
        node.close()
        done.set()
        executor.wake()
        spinning.join()
        executor.shutdown()
        node.destroy_node()
    return failure or node.lost


def _first(ended: SimpleQueue[Exception | None]) -> Exception | None:
    """First entry of the queue; wakes up now and then, for a signal that another thread received does not wake us."""
    while True:
        with suppress(Empty):
            return ended.get(timeout=0.2)


def _initialise(arguments: Sequence[str]) -> None:
    """Start ROS, with signals left to us; raises InputError for arguments that are neither of ROS nor ``--help``."""
    parser = argparse.ArgumentParser(
        prog="wheelset-track-sim node",
        usage="%(prog)s [--ros-args -p NAME:=VALUE ... --params-file FILE ...]",
        description="The ROS 2 node. Its parameters describe themselves: ros2 param describe /wheelset_track_sim NAME",
    )
    try:
        rest = rclpy.utilities.remove_ros_args(arguments)
        _, unknown = parser.parse_known_args(rest)
        if unknown:
            raise InputError(f"{unknown[0]} is not an argument of the node: see wheelset-track-sim node --help")
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    except (_rclpy.RCLInvalidROSArgsError, _rclpy.UnknownROSArgsError) as refusal:
        raise InputError(f"arguments of ROS: {' '.join(str(refusal).split())}") from None
