"""The bag that a node writes, if it writes one."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from pathlib import Path

from ..recording.bag_writer import PREFIX, BagWriter
from ..recording.messages import Message
from ..recording.origin import run_info
from ..simulation.simulator import Simulator


class Recorder:
    """At most one open bag; its methods may be called from any thread."""

    def __init__(self, prefix: str) -> None:
        """``prefix`` stands before the topics in the bag: the name of the node with its namespace."""
        self._prefix = prefix
        self._lock = threading.Lock()
        self._bag: BagWriter | None = None

    @property
    def path(self) -> str:
        """Path of the open bag; empty if there is none."""
        bag = self._bag
        return str(bag.path) if bag else ""

    def start(self, folder: str, name: str, simulator: Simulator, start_ns: int) -> None:
        """Open a bag, unless one is open; raises InputError if it exists or cannot be written."""
        path = Path(folder).expanduser() / (name or name_now(self._prefix))
        with self._lock:
            if self._bag is None:
                self._bag = BagWriter(path, run_info(simulator), start_ns=start_ns, prefix=self._prefix)

    def write(self, messages: Iterable[Message]) -> None:
        """Record messages if a bag is open; raises RecordingError if the disk refuses."""
        with self._lock:
            if self._bag is not None:
                self._bag.write_messages(messages)

    def stop(self) -> None:
        """Close the bag if one is open; raises RecordingError if the disk refuses."""
        with self._lock:
            bag, self._bag = self._bag, None
            if bag is not None:
                bag.close()


def name_now(node: str) -> str:
    """Name of a bag by date and time, and by that of the node if it has one of its own: a fleet starts at one time."""
    own = "" if node == PREFIX else node.replace("/", "_")
    return time.strftime("run_%Y%m%d_%H%M%S") + own
