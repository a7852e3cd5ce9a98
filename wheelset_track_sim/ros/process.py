"""The process of the node, or of a fleet of them: arguments, executor, signals, exit."""

from __future__ import annotations

import argparse
import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from queue import Empty, SimpleQueue
from types import FrameType
from typing import NamedTuple

import rclpy
from rclpy.exceptions import InvalidHandle, InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import MultiThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.signals import SignalHandlerOptions

from ..errors import InputError
from ..simulation.fleet import ModelPool
from .names import fleet_names
from .node import NAME, SimulationNode


class Ending(NamedTuple):
    """A node that is through by itself, or, without one, a signal."""

    node: int | None
    failure: Exception | None


Endings = SimpleQueue[Ending]


def main(arguments: Sequence[str]) -> int:
    """Run the node, or a fleet, until all end by themselves or are told to by a signal; returns 0.

    Raises InputError for arguments or parameters that cannot be used, WheelsetTrackError if a run failed.
    """
    names = _initialise(arguments)
    endings: Endings = SimpleQueue()  # its put is safe in a signal handler

    def stop(number: int, frame: FrameType | None) -> None:
        endings.put(Ending(None, None))

    handlers = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        failure = _run(names, endings)
    except (InvalidNodeNameException, InvalidNamespaceException) as refusal:
        raise InputError(" ".join(str(refusal).split())) from None
    finally:
        rclpy.try_shutdown()
        for number, handler in handlers.items():
            signal.signal(number, handler)
    if failure is not None:
        raise failure
    return 0


def _run(names: Sequence[str], endings: Endings) -> Exception | None:
    """The nodes and their executor; returns what made one fail first, or what befell a bag."""
    models = ModelPool()
    nodes: list[SimulationNode] = []
    with ExitStack() as stack:
        for number, name in enumerate(names):
            node = SimulationNode(partial(_put, endings, number), name, models)
            stack.callback(node.destroy_node)
            nodes.append(node)
        called = [node.get_fully_qualified_name() for node in nodes]
        if len(set(called)) < len(called):
            raise InputError(f"all nodes of the fleet are called {called[0]}: do not rename them by __node")
        executor = MultiThreadedExecutor(
            num_threads=2 * len(nodes) + 2
        )  # a change and a transition of each may take long
        stack.callback(executor.shutdown)
        for node in nodes:
            executor.add_node(node)
        with _spinning(executor):
            try:
                for node in nodes:
                    if node.parameters["autostart"]:
                        executor.create_task(node.autostart)
                failure = _all(endings, nodes)
            finally:
                for node in nodes:
                    node.close()
    return failure or next((node.lost for node in nodes if node.lost is not None), None)


def _put(endings: Endings, number: int, failure: Exception | None) -> None:
    endings.put(Ending(number, failure))


@contextmanager
def _spinning(executor: MultiThreadedExecutor) -> Iterator[None]:
    done = threading.Event()

    def spin() -> None:
        while not done.is_set():
            with suppress(InvalidHandle):  # of a publisher that a transition has taken away meanwhile
                executor.spin_once(timeout_sec=1.0)

    thread = threading.Thread(target=spin, name="executor")
    thread.start()
    try:
        yield
    finally:
        done.set()
        executor.wake()
        thread.join()


def _all(endings: Endings, nodes: Sequence[SimulationNode]) -> Exception | None:
    """Wait for all nodes to end, each closed when it does; for one only if it has bad input; returns the first failure.

    A wheelset that cannot go on leaves the others running.
    """
    running, first = set(range(len(nodes))), None
    while running:
        ending = _next(endings)
        if ending.node is None:
            return first
        running.discard(ending.node)
        first = first or ending.failure
        if isinstance(ending.failure, InputError):
            return first
        nodes[ending.node].close()
    return first


def _next(endings: Endings) -> Ending:
    """Next entry of the queue; wakes up now and then, for a signal that another thread received does not wake us."""
    while True:
        with suppress(Empty):
            return endings.get(timeout=0.2)


def _initialise(arguments: Sequence[str]) -> list[str]:
    """Start ROS, with signals left to us; names of the nodes. InputError for arguments that are not of ROS or ours."""
    parser = argparse.ArgumentParser(
        prog="wheelset-track-sim node",
        usage="%(prog)s [--fleet N | NAME,NAME,...] [--ros-args -p NAME:=VALUE ... --params-file FILE ...]",
        description="The ROS 2 node. Its parameters describe themselves: ros2 param describe /wheelset_track_sim NAME",
        exit_on_error=False,
    )
    parser.add_argument(
        "--fleet",
        metavar="N | NAME,NAME,...",
        help="several nodes in one process, each with topics, parameters and lifecycle of its own: "
        "wheelset_1 to wheelset_N, or the names given",
    )
    try:
        rest = rclpy.utilities.remove_ros_args(arguments)
        given, unknown = parser.parse_known_args(rest)
        if unknown:
            raise InputError(f"{unknown[0]} is not an argument of the node: see wheelset-track-sim node --help")
        names = [NAME] if given.fleet is None else fleet_names(given.fleet)
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    except argparse.ArgumentError as refusal:
        raise InputError(f"{refusal}: see wheelset-track-sim node --help") from None
    except (_rclpy.RCLInvalidROSArgsError, _rclpy.UnknownROSArgsError) as refusal:
        raise InputError(f"arguments of ROS: {' '.join(str(refusal).split())}") from None
    return names
