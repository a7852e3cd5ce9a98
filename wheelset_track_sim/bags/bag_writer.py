"""Bags as ``ros2 bag`` reads them, written without ROS: MCAP with CDR messages and zstd chunks."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack, suppress
from pathlib import Path
from shutil import rmtree

from ..errors import InputError, RecordingError
from .bag_file import BagFile
from .inputs import Input
from .messages import Message, state_again
from .rosbag2_metadata import METADATA, Part, Topic, write_folder_metadata
from .run_info import RunInfo
from .settings import RecordSettings
from .writer import PREFIX, Writer, creating

CHUNK_PERIOD_NS = 100_000_000
"""A chunk of the file is closed when it holds this time of the run: what a crash can lose."""
SECOND_NS = 1_000_000_000
STATE = "SimulationState"
BEGINNINGS = {"ContactForces", STATE}
"""Messages that a file of a bag may begin with."""


class BagWriter(Writer):
    """One bag while it is written; a context manager that leaves a readable bag, also after an exception.

    A path that ends in ``.mcap`` is one file, any other a bag folder with ``metadata.yaml`` and files, each of which
    begins with the state and can be read alone: ``split`` begins another one, and so do the bounds in ``settings``. An
    exception before the first message leaves nothing behind.

    What is written is at the operating system within 0.1 s of the run: it outlives the process. ``sync`` makes it
    outlive a power failure.
    """

    def __init__(
        self,
        path: str | Path,
        info: RunInfo,
        *,
        start_ns: int,
        prefix: str = PREFIX,
        settings: RecordSettings | None = None,
        state: Message | None = None,
    ) -> None:
        """Create the bag; ``start_ns`` is the time stamp of step 0, ns since the epoch.

        ``state`` holds already where the bag begins, and is told there if no other is. Raises InputError if the path
        exists or cannot be written, or is a single file that ``settings`` would split.
        """
        super().__init__(Path(path), start_ns)
        self.prefix = prefix.rstrip("/")
        self._info = info
        self._settings = settings or RecordSettings()
        self._folder = None if self.path.suffix == ".mcap" else self.path
        if self._folder is None and self._settings.splits:
            raise InputError(f"{self.path} is a single file, which cannot be split: give a folder, without .mcap")
        self._topics: dict[str, Topic] = {}
        self._parts: list[Part] = []  # that are finished
        self._number = 0
        self._flushed_ns = self._end_ns = start_ns
        self._state = state
        self._state_due = True
        self._note = ""
        self._open = True
        with creating(self.path), ExitStack() as undo:
            if self._folder is None:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            else:
                self._folder.mkdir(parents=True)
                undo.callback(rmtree, self._folder, ignore_errors=True)
            self._file = BagFile(self._path_of(0), info, self.prefix, start_ns)
            undo.callback(self._file.abandon)
            self._write_folder_metadata()
            undo.pop_all()

    @property
    def file(self) -> Path:
        """The file at hand."""
        return self._file.path

    @property
    def bound(self) -> int:
        """Bytes of its files, those at most if it is closed now."""
        return self._finished_size + (self._file.bound if self._open else self._file.size)

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages that belong together; they stay in one chunk of the file.

        Raises RecordingError if the disk refuses; the bag is finished then, as far as the disk lets.
        """
        self._require_open()
        together = [*messages]
        size = sum(len(message.cdr) for message in together)  # all are made before one is taken in: a Ctrl-C parts none
        try:
            if together and together[0].kind in BEGINNINGS:
                self._make_room(together[0].stamp_ns, size)
            for message in together:
                self._add(message)
            if self._end_ns - self._flushed_ns >= CHUNK_PERIOD_NS:
                self._file.flush()
                self._flushed_ns = self._end_ns
        except OSError as reason:
            raise self._refused(reason) from reason

    def gap(self, note: str) -> None:
        """Tell that what comes next does not follow what is written; it goes into another file if the bag is a folder.

        The state is told again there, with the ``note``. Raises RecordingError if the disk refuses.
        """
        self._note = note
        if self._folder is not None and self._file.holds_messages:
            self.split()

    def split(self) -> Path:
        """Finish the file at hand and go on in the next one of the folder, which is returned.

        Raises InputError, and goes on as before, if the bag is no folder or the file at hand is empty; RecordingError
        if the disk refuses.
        """
        self._require_open()
        if self._folder is None:
            raise InputError(f"{self.path} is a single file, which cannot be split: record into a folder")
        if not self._file.holds_messages:
            raise InputError(f"{self.file} holds nothing yet: split it later")
        try:
            self._next_file()
        except OSError as reason:
            raise self._refused(reason) from reason
        return self.file

    def snapshot(self) -> Path:
        """Raises InputError: everything is in the bag."""
        raise InputError(f"{self.path} holds everything: record in snapshot mode to take snapshots")

    def sync(self) -> None:
        """Wait until all that is at the operating system is on the disk, so that a power failure does not take it.

        Raises RecordingError if the disk refuses.
        """
        self._require_open()
        try:
            self._file.sync()
        except OSError as reason:
            raise self._refused(reason) from reason

    def close(self) -> None:
        """Finish the bag; closing again does nothing. Raises RecordingError if the disk refuses."""
        if not self._open:
            return
        try:
            self._file.finish()
            self._write_folder_metadata()
        except OSError as reason:
            raise self._refused(reason) from reason
        self._open = False

    def remove_if_empty(self) -> None:
        """Remove the bag, which is closed, if it holds nothing."""
        if not self._topics:
            self.remove()

    def remove(self) -> None:
        """Remove all files of the bag, which is closed, and its folder if there is nothing else in it."""
        if self._folder is None:
            self.file.unlink(missing_ok=True)
            return
        for name in [*(part.name for part in self._parts), self.file.name, METADATA]:
            (self._folder / name).unlink(missing_ok=True)
        with suppress(OSError):
            self._folder.rmdir()

    def _require_open(self) -> None:
        if not self._open:
            raise RecordingError(f"{self.path} is closed: nothing more can be recorded in it")

    def _path_of(self, number: int) -> Path:
        return self.path if self._folder is None else self._folder / f"{self.path.name}_{number}.mcap"

    @property
    def _finished_size(self) -> int:
        return sum(part.size for part in self._parts)

    def _next_file(self) -> None:
        before = self._file
        before.finish()
        self._file = BagFile(self._path_of(self._number + 1), self._info, self.prefix, self._end_ns)
        self._number += 1
        self._parts.append(before.part)
        self._state_due = True
        self._write_folder_metadata()

    def _make_room(self, stamp_ns: int, more: int) -> None:
        """Go on in another file, and remove the oldest ones, where the bounds ask for it before ``more`` bytes."""
        settings = self._settings
        if not settings.splits:
            return
        full = 0 < settings.file_size < self._file.bound + more
        long = 0 < settings.max_duration * SECOND_NS <= stamp_ns - self._file.begin_ns
        if self._file.holds_messages and (full or long):
            self._next_file()
        while self._parts and 0 < settings.max_total_size < self.bound + more:
            oldest = self._parts.pop(0)
            self._write_folder_metadata()
            self._path_of(0).with_name(oldest.name).unlink(missing_ok=True)

    def _add(self, message: Message) -> None:
        if message.kind == STATE:  # what the next file begins with
            self._state, self._state_due, of = message, False, message.fields
            self._info = self._info.with_input(Input(of["revision"], of["first_step"], of["scenario"]))
        elif (self._state_due or self._note) and message.kind in BEGINNINGS:
            self._tell_state(message)
        self._file.add(message)
        self._topics.setdefault(message.topic, self._file.topics[message.topic])
        self._end_ns = max(self._end_ns, message.end_ns)

    def _tell_state(self, chunk: Message) -> None:
        """Tell the state again before a chunk that a file begins with."""
        again = state_again(self._state, chunk, self._note) if self._state is not None else None
        self._note, self._state_due = "", False
        if again is not None:
            self._add(again)

    def _write_folder_metadata(self) -> None:
        if self._folder is not None:
            write_folder_metadata(self._folder, [*self._parts, self._file.part], [*self._topics.values()])

    def _refused(self, reason: OSError) -> RecordingError:
        self._open = False
        self._file.abandon()
        with suppress(OSError):
            self._write_folder_metadata()
        return RecordingError(
            f"{self.path} cannot be written further ({reason.strerror}): free space or give another path"
        )
