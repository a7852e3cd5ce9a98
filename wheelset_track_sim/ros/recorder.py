"""The bag that a node writes, if it writes one."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from itertools import count
from pathlib import Path

from ..errors import InputError, RecordingError
from ..recording.bag_writer import PREFIX, BagWriter
from ..recording.messages import Message
from ..recording.origin import run_info
from ..simulation.simulator import Simulator

LONGEST_NAME = 200
"""Bytes of a name that comes over ROS."""


class Recorder:
    """At most one open bag; its methods may be called from any thread."""

    def __init__(self, prefix: str) -> None:
        """``prefix`` stands before the topics in the bag: the name of the node with its namespace."""
        self._prefix = prefix
        self._lock = threading.Lock()
        self._bag: BagWriter | None = None
        self._first = self._beside = Path()
        self.lost: RecordingError | None = None
        """What ended the last recording before its time."""

    @property
    def path(self) -> str:
        """Path of the open bag; empty if there is none."""
        bag = self._bag
        return str(bag.path) if bag else ""

    def start(self, path: Path, simulator: Simulator, start_ns: int) -> None:
        """Open a bag; ``start_ns`` is the time stamp of step 0, ns.

        Raises InputError if one is open, or this one exists or cannot be written.
        """
        with self._lock:
            if self._bag is not None:
                raise InputError(f"{self._bag.path} is being recorded: stop it first")
            self._bag = BagWriter(path, run_info(simulator), start_ns=start_ns, prefix=self._prefix)
            self._first = self._first if path == self._beside else path
            self.lost = None

    def write(self, messages: Iterable[Message]) -> None:
        """Record messages if a bag is open; what the disk refuses ends the recording and is raised: RecordingError."""
        with self._lock:
            if self._bag is not None:
                try:
                    self._bag.write_messages(messages)
                except RecordingError as reason:
                    self._give_up(reason)
                    raise

    def split(self) -> Path:
        """Go on in the next file of the bag, which is returned; InputError if there is nothing to split.

        What the disk refuses ends the recording and is raised: RecordingError.
        """
        with self._lock:
            if self._bag is None:
                raise InputError("nothing is being recorded: start a recording first")
            try:
                return self._bag.split()
            except RecordingError as reason:
                self._give_up(reason)
                raise

    def stop(self) -> str:
        """Close the bag if one is open; returns its path, or nothing. Raises RecordingError if the disk refuses."""
        with self._lock:
            bag, self._bag = self._bag, None
            if bag is None:
                return ""
            try:
                bag.close()
            except RecordingError as reason:
                self.lost = reason
                raise
            return str(bag.path)

    def _give_up(self, reason: RecordingError) -> None:
        bag, self._bag, self.lost = self._bag, None, reason
        if bag is not None:
            try:
                bag.close()
            except RecordingError:
                return  # the first error is the one to tell

    def beside(self) -> Path:
        """A bag for the next run, beside that of the first: the first of ``PATH_2``, ``PATH_3``, ... that is free."""
        first = self._first
        tried = (first.with_name(f"{first.stem}_{number}{first.suffix}") for number in count(2))
        self._beside = next(path for path in tried if not path.exists())
        return self._beside

    def path_now(self, folder: str) -> Path:
        """A bag in ``folder`` by date and time, and by the name of the node if it has one of its own."""
        return Path(folder).expanduser() / name_now(self._prefix)


def path_below(folder: str, name: str) -> Path:
    """The bag ``name`` below ``folder``; InputError for a name that is too long or leads out of it, also by a link."""
    shown = repr(name if len(name) < 50 else name[:50] + "...")
    size = len(name.encode(errors="surrogatepass"))
    if size > LONGEST_NAME:
        raise InputError(f"name = {shown} has {size} bytes: give at most {LONGEST_NAME}")
    if not name.isprintable():
        raise InputError(f"name = {shown} holds characters that cannot be printed: give letters, digits and such")
    base = Path(folder).expanduser().resolve()
    try:
        path = (base / name).resolve()
    except (OSError, RuntimeError):  # a link to itself
        path = base
    if Path(name).is_absolute() or ".." in Path(name).parts or base not in path.parents:
        raise InputError(f"name = {shown} leads out of {base}: give a path below it, without ..")
    return path


def name_now(node: str) -> str:
    """Name of a bag by date and time, and by that of the node if it has one of its own: a fleet starts at one time."""
    own = "" if node == PREFIX else node.replace("/", "_")
    return time.strftime("run_%Y%m%d_%H%M%S") + own
