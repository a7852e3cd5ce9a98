"""The bag that a node writes, if it writes one."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path

from ..bags.bag_writer import PREFIX
from ..bags.buffered import BufferedWriter
from ..bags.messages import Message
from ..bags.settings import RecordSettings
from ..bags.snapshots import writer_of
from ..errors import InputError, RecordingError
from ..simulation.simulator import Simulator
from .run_messages import run_info

LONGEST_NAME = 200
"""Bytes of a name that comes over ROS."""
LONGEST_OF_FILE = 255
"""Bytes of a name that file systems take."""


@dataclass(frozen=True)
class RecordingFigures:
    """State of the recording."""

    path: str = ""
    """Of the open bag; empty if there is none."""
    lost: Exception | None = None
    """What the bag lost, or why the last one ended early."""
    refused: Exception | None = None
    """Why no bag could be opened."""
    waiting: int = 0
    """Bytes that wait for the disk."""
    buffer_size: int = 0
    """Largest number of bytes that may wait."""


class Recorder:
    """At most one open bag; its methods may be called from any thread, and return futures where they need the disk."""

    def __init__(self, prefix: str, log: Callable[[str], object]) -> None:
        """``prefix`` comes before the topics in the bag: the name of the node with its namespace.

        ``log`` is called in any thread with what a bag loses.
        """
        self._prefix, self._log = prefix, log
        self._lock = threading.Lock()
        self._bag: BufferedWriter | None = None
        self._first = self._beside = Path()
        self.settings = RecordSettings()
        """Of the recordings that begin from now on."""
        self.patient = False
        """Whether samples wait for the disk, because the run keeps no time."""
        self._refused: InputError | None = None
        self.lost: RecordingError | None = None
        """What the last recording lost, or why it ended early."""

    @property
    def path(self) -> str:
        """Path of the open bag; empty if there is none."""
        bag = self._bag
        return str(bag.path) if bag else ""

    @property
    def bag(self) -> BufferedWriter:
        """The open bag; InputError if there is none."""
        bag = self._bag
        if bag is None:
            raise InputError("nothing is being recorded: start a recording first")
        return bag

    @property
    def figures(self) -> RecordingFigures:
        """State of the recording."""
        bag = self._bag
        waiting = bag.waiting if bag else 0
        return RecordingFigures(self.path, self.lost, self._refused, waiting, self.settings.buffer_size)

    def open(self, path: Path, simulator: Simulator, start_ns: int) -> BufferedWriter:
        """Open a bag for ``take``, which waits for the disk; ``start_ns`` is the time stamp of step 0, ns.

        Raises InputError if another bag is being recorded, or this one exists or cannot be written.
        """
        self._require_none()
        info, settings = run_info(simulator), self.settings
        try:
            bag = writer_of(path, info, settings, start_ns=start_ns, prefix=self._prefix)
        except InputError as refusal:
            self._refused = refusal
            raise
        return BufferedWriter(bag, settings.buffer_size, partial(self._on_loss, bag.path))

    def take(self, bag: BufferedWriter) -> None:
        """Record to an open bag from the next message on; InputError if another one is being recorded."""
        with self._lock:
            if self._bag is None:
                self._first = self._first if bag.path == self._beside else bag.path
                self._bag, self.lost, self._refused = bag, None, None
                return
        bag.discard()
        self._require_none()

    def write(self, messages: Iterable[Message]) -> None:
        """Record messages if a bag is open."""
        bag = self._bag
        if bag is not None:
            bag.put(messages, patient=self.patient)

    def stop(self) -> Future[str]:
        """Record no more, and close the bag if one is open: the result is its path, or an empty one.

        The result is RecordingError if the disk refuses.
        """
        with self._lock:
            bag, self._bag = self._bag, None
        if bag is not None:
            return bag.close()
        nothing: Future[str] = Future()
        nothing.set_result("")
        return nothing

    def beside(self) -> Path:
        """A bag for the next run, beside that of the first: the first free one of ``PATH_2``, ``PATH_3``, ..."""
        first = self._first
        tried = (first.with_name(f"{first.stem}_{number}{first.suffix}") for number in count(2))
        self._beside = next(path for path in tried if not _exists(path))
        return self._beside

    def path_now(self, folder: str) -> Path:
        """A bag in ``folder``, named by date, time, and the name of the node unless that is the default."""
        return Path(folder).expanduser() / name_now(self._prefix)

    def _on_loss(self, path: Path, reason: RecordingError, ended: bool) -> None:
        with self._lock:
            self.lost = reason
            if ended and self._bag is not None and self._bag.path == path:
                self._bag = None
        self._log(f"recording ends here: {reason}" if ended else str(reason))

    def _require_none(self) -> None:
        bag = self._bag
        if bag is not None:
            raise InputError(f"{bag.path} is being recorded: stop it first")


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name that is too long: creating it says so
        return False


def path_below(folder: str, name: str, longest: int = LONGEST_NAME) -> Path:
    """The path ``name`` below ``folder``; InputError for a name that leads out of it, also by a link, or is too long.

    ``longest`` is in bytes.
    """
    shown = repr(name if len(name) < 50 else name[:50] + "...")
    size = len(name.encode(errors="surrogatepass"))
    if size > longest:
        raise InputError(f"name = {shown} has {size} bytes: give at most {longest}")
    if not name.isprintable():
        raise InputError(f"name = {shown} holds characters that cannot be printed: give letters, digits and such")
    base = Path(folder).expanduser().resolve()
    try:
        path = (base / name).resolve()
    except (OSError, RuntimeError):  # a link to itself
        path = base
    if Path(name).is_absolute() or ".." in Path(name).parts or base not in path.parents:
        raise InputError(f"name = {shown} points outside {base}: give a path below it, without ..")
    return path


def name_now(node: str) -> str:
    """Name of a bag by date and time, and by the node unless it has the default name: a fleet starts at one time."""
    own = "" if node == PREFIX else node.replace("/", "_")
    return time.strftime("run_%Y%m%d_%H%M%S") + own
