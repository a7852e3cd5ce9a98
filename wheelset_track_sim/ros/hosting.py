"""A process with nodes in it, whatever they are: ROS from its start to its end, signals, executor, who has ended."""

from __future__ import annotations

import re
import signal
import threading
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from types import FrameType
from typing import NamedTuple

import rclpy
from rclpy.exceptions import InvalidHandle, InvalidNamespaceException, InvalidNodeNameException
from rclpy.executors import Executor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.logging import get_logger
from rclpy.signals import SignalHandlerOptions

from ..errors import InputError


class Ending(NamedTuple):
    """A node that is through by itself, or, without one, a signal."""

    node: int | None
    failure: Exception | None


Endings = SimpleQueue[Ending]

NO_SECURITY = (
    "ROS_SECURITY_ENABLE is set, but this build of Fast DDS has no security: use a system installation of ROS 2 "
    "(docs/howto/monitoring.md, Security), or unset it"
)


def own_arguments(arguments: Sequence[str]) -> list[str]:
    """``arguments`` without those of ROS; raises InputError if ROS cannot use its own."""
    with refusing():
        own: list[str] = rclpy.utilities.remove_ros_args(arguments)
    return own


@contextmanager
def session(arguments: Sequence[str]) -> Iterator[Endings]:
    """ROS with ``arguments``, of which it takes its own; the queue that yields tells what ends, signals among it.

    Raises InputError for arguments and names that ROS cannot use.
    """
    with refusing():
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    endings: Endings = SimpleQueue()  # its put is safe in a signal handler

    def stop(number: int, frame: FrameType | None) -> None:
        endings.put(Ending(None, None))

    handlers = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield endings
    except (InvalidNodeNameException, InvalidNamespaceException) as refusal:
        raise InputError(" ".join(str(refusal).split())) from None
    finally:
        rclpy.try_shutdown()
        for number, handler in handlers.items():
            signal.signal(number, handler)


@contextmanager
def spinning(executor: Executor) -> Iterator[None]:
    """An executor in a thread of its own; what callbacks raise, such as ``rclpy``'s on a strange message, is logged."""
    done = threading.Event()

    def spin() -> None:
        while not done.is_set():
            with _going_on():
                executor.spin_once(timeout_sec=1.0)

    thread = threading.Thread(target=spin, name="executor")
    thread.start()
    try:
        yield
    finally:
        done.set()
        executor.wake()
        thread.join()


def next_ending(endings: Endings) -> Ending:
    """Next entry of the queue; wakes up now and then, for a signal that another thread received does not wake us."""
    while True:
        with suppress(Empty):
            return endings.get(timeout=0.2)


@contextmanager
def _going_on() -> Iterator[None]:
    try:
        yield
    except InvalidHandle:  # of a publisher that a transition has taken away meanwhile
        pass
    except Exception:  # noqa: BLE001  the nodes must be served on
        get_logger("executor").error(traceback.format_exc())


@contextmanager
def refusing() -> Iterator[None]:
    """Turn what ROS refuses while it starts, or while it makes a node, into an InputError of one line."""
    try:
        yield
    except (_rclpy.RCLInvalidROSArgsError, _rclpy.UnknownROSArgsError) as refusal:
        raise InputError(f"arguments of ROS: {_line(refusal)}") from None
    except _rclpy.RCLError as refusal:
        if "security libraries" in str(refusal):
            raise InputError(NO_SECURITY) from None
        if "logging" in str(refusal):
            raise InputError(
                f"ROS cannot write its log ({_line(refusal)}): set ROS_LOG_DIR or HOME to a folder that can be written"
            ) from None
        raise InputError(f"ROS does not start: {_line(refusal)}") from None


def _line(refusal: Exception) -> str:
    """Text of an error of ROS without the place in its source."""
    return re.sub(r", at /\S+:\d+", "", " ".join(str(refusal).split()))
