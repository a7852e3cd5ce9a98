"""``node``, ``replay``, and ``get``, ``set``, ``call`` and ``echo`` of a running node: the commands that need ROS 2."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.yaml12 import dump
from ..scenario import change_of
from .console import print_object, terminal
from .loading import loaded

LONGEST = 3600.0
"""Longest time to wait for a node, s."""
SHORT = 8
"""Numbers of a list that ``echo`` prints one by one."""


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


def get(name: str, parameters: Sequence[str], patience: float, *, json: bool) -> int:
    """Print parameters of a running node; returns the exit status."""
    with _remote("get", name, patience) as node:
        found = node.parameters(parameters)
    print_object(found) if json else _print(found)
    return 0


def set_parameters(name: str, changes: Sequence[str], patience: float) -> int:
    """Set parameters of a running node, all or none, and print its answer; returns the exit status."""
    values = dict(change_of(change, "set") for change in changes)
    with _remote("set", name, patience) as node:
        _say(node.set_parameters(values) or "set")
    return 0


def call(name: str, service: str, fields: Sequence[str], patience: float, *, json: bool) -> int:
    """Call a service of a running node and print its answer; returns the exit status: 1 if it answers no success."""
    request = dict(change_of(field, "call") for field in fields)
    with _remote("call", name, patience) as node:
        answer = node.call(service, request)
    print_object(answer) if json else _print(answer)
    return 0 if answer.get("success", True) else 1


def echo(name: str, topic: str, count: int | None, patience: float, *, json: bool, full: bool) -> int:
    """Print messages of a topic until there have been ``count``, or an interrupt; returns the exit status."""
    with _remote("echo", name, patience) as node:
        for message in islice(node.messages(topic), count):
            if json:
                print_object(message)
            else:
                _print(message if full else _short(message))
                _say("---")
            sys.stdout.flush()
    return 0


@contextmanager
def _remote(command: str, name: str, patience: float) -> Iterator[Any]:
    if not 0 < patience <= LONGEST:
        raise InputError(f"--timeout {patience:g} s is out of range: give a time above 0, up to {LONGEST:g} s")
    with _needs_ros(command):
        from ..ros.client import connected
    with connected(name, patience) as node:
        yield node


def _short(value: Any) -> Any:
    """Plain values in which long lists of numbers are replaced by their count and range."""
    if isinstance(value, dict):
        return {key: _short(item) for key, item in value.items()}
    if isinstance(value, list) and len(value) > SHORT and all(isinstance(item, (int, float)) for item in value):
        return f"{len(value)} values from {min(value):g} to {max(value):g}"
    return [_short(item) for item in value] if isinstance(value, list) else value


def _print(values: Any) -> None:
    _say(dump(values).rstrip())


def _say(text: str) -> None:
    terminal().print(text, highlight=False, soft_wrap=True)


@contextmanager
def _needs_ros(command: str) -> Iterator[None]:
    """Around the import of a node: raises InputError in one line without ROS 2 or the built messages."""
    try:
        yield
        loaded()
    except ModuleNotFoundError as missing:
        if missing.name not in {"rclpy", "wheelset_track_msgs"}:
            raise
        raise InputError(
            f"{command} needs ROS 2 Jazzy, but {missing.name} is not installed: run make setup, or source ROS 2"
        ) from None
