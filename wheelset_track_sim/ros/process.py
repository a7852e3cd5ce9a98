"""The process of the node, or of a fleet of them: arguments, executor, exit."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial

from rclpy.executors import MultiThreadedExecutor

from ..errors import InputError
from ..simulation.fleet import ModelPool
from .hosting import Ending, Endings, next_ending, own_arguments, refusing, session, spinning
from .names import fleet_names
from .node import NAME, SimulationNode


def main(arguments: Sequence[str]) -> int:
    """Run the node, or a fleet, until all have ended, or a signal ends them; returns 0.

    Raises InputError for arguments or parameters that cannot be used, WheelsetTrackError if a run failed.
    """
    names = _names(arguments)
    with session(arguments) as endings:
        failure = _run(names, endings)
    if failure is not None:
        raise failure
    return 0


def _run(names: Sequence[str], endings: Endings) -> Exception | None:
    """The nodes and their executor; returns what made one fail first, or what befell a bag."""
    models = ModelPool()
    nodes: list[SimulationNode] = []
    with ExitStack() as stack:
        for number, name in enumerate(names):
            with refusing():
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
        stack.callback(executor._executor.shutdown)  # before: a callback still queued then would raise, and say so
        for node in nodes:
            executor.add_node(node)
        with spinning(executor):
            try:
                for node in nodes:
                    if node.parameters["autostart"]:
                        executor.create_task(node.autostart)
                failure = _all(endings, nodes)
            finally:
                _close(nodes)
    return failure or next((node.lost for node in nodes if node.lost is not None), None)


def _put(endings: Endings, number: int, failure: Exception | None) -> None:
    endings.put(Ending(number, failure))


def _all(endings: Endings, nodes: Sequence[SimulationNode]) -> Exception | None:
    """Wait for all nodes to end, each closed when it does; for one only if it has bad input; returns the first failure.

    A wheelset that cannot go on leaves the others running.
    """
    running, first = set(range(len(nodes))), None
    while running:
        ending = next_ending(endings)
        if ending.node is None:
            return first
        running.discard(ending.node)
        first = first or ending.failure
        if isinstance(ending.failure, InputError):
            return first
        nodes[ending.node].close()
    return first


def _close(nodes: Sequence[SimulationNode]) -> None:
    """Close all; none first waits for models that another one builds, or for its change."""
    for node in nodes:
        node.interrupt()
    for node in nodes:
        node.close()


def _names(arguments: Sequence[str]) -> list[str]:
    """Names of the nodes; raises InputError for arguments that are neither of ROS nor ours."""
    parser = argparse.ArgumentParser(
        prog="wheelset-track-sim node",
        usage="%(prog)s [--fleet N | NAME,NAME,...] [--ros-args -p NAME:=VALUE ... --params-file FILE ...]",
        description="Run the ROS 2 node. To describe a parameter: ros2 param describe /wheelset_track_sim NAME",
        exit_on_error=False,
    )
    parser.add_argument(
        "--fleet",
        metavar="N | NAME,NAME,...",
        help="run several nodes in one process, each with its own topics, parameters and lifecycle: "
        "wheelset_1 to wheelset_N, or the names given",
    )
    try:
        given, unknown = parser.parse_known_args(own_arguments(arguments))
        if unknown:
            raise InputError(f"{unknown[0]} is not an argument of the node: see wheelset-track-sim node --help")
        return [NAME] if given.fleet is None else fleet_names(given.fleet)
    except argparse.ArgumentError as refusal:
        raise InputError(f"{refusal}: see wheelset-track-sim node --help") from None
