"""Bags as ``ros2 bag`` reads them, written without ROS: MCAP with CDR messages and zstd chunks."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from ..errors import InputError, RecordingError
from ..samples.block import SampleBlock
from ..samples.impacts import Impact
from ..samples.summary import Summary
from ..samples.turns import NO_TURN, TurnPeaks
from .bag_file import BagFiles
from .folder_files import is_mcap
from .messages import Message, State, chunk_messages, impact_message, state_again, state_message
from .run_info import METADATA_NAME, Input, RunInfo
from .settings import RecordSettings
from .topics import Topic, topic_of_node

if TYPE_CHECKING:
    from typing_extensions import Self

PREFIX = "/wheelset_track_sim"
CHUNK_PERIOD_NS = 100_000_000
"""A chunk of the file is closed when it holds this time of the run, which a crash can lose."""
SECOND_NS = 1_000_000_000
STATE = "SimulationState"
BEGINNINGS = {"ContactForces", STATE}
"""Messages that a file of a bag may begin with."""


class Writer(ABC):
    """A context manager that leaves a readable bag, also after an exception; only one thread may write.

    An exception before the first message leaves nothing behind.
    """

    path: Path
    start_ns: int
    """Time stamp of step 0, ns since the epoch."""

    @abstractmethod
    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages that belong together: a chunk with its impacts, or a state.

        Raises RecordingError if the disk refuses; the bag is finished then, as far as the disk allows.
        """

    @abstractmethod
    def close(self, *, sync: bool = False) -> None:
        """Finish, and with ``sync`` wait until all is on the disk; closing again does nothing.

        Raises RecordingError if the disk refuses.
        """

    @abstractmethod
    def remove_if_empty(self) -> None:
        """Remove a closed bag without messages."""

    def write(
        self,
        block: SampleBlock,
        *,
        summary: Summary | None = None,
        turn: TurnPeaks = NO_TURN,
        impacts: Iterable[Impact] = (),
        real_time_factor: float = math.nan,
        lag: float = 0.0,
    ) -> None:
        """Record one block with the ``impacts`` that ended in it; RecordingError if the disk refuses.

        ``summary`` is that of the block if it is known already, ``turn`` the last complete turn of the wheels.
        """
        chunk = chunk_messages(
            block, self.start_ns, real_time_factor=real_time_factor, lag=lag, summary=summary, turn=turn
        )
        self.write_messages([*chunk, *(impact_message(impact, self.start_ns) for impact in impacts)])

    def write_state(self, state: State) -> None:
        """Record what is simulated from a step on: at the start, and at every revision."""
        self.write_messages([state_message(state, self.start_ns)])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        with suppress(RecordingError):  # the first error is the one to report
            self.close()
        self.remove_if_empty()


class BagWriter(Writer):
    """One bag while it is written.

    A path that ends in ``.mcap`` is one file. Any other path is a bag folder with ``metadata.yaml`` and files, each of
    which begins with the state and can be read alone; ``split`` begins another one, and so do the bounds in
    ``settings``. Messages reach the operating system within 0.1 s of the run, and then outlive the process; ``sync``
    makes them outlive a power failure.
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

        ``state`` is in force where the bag begins, and is repeated there unless another one comes first. Raises
        InputError if the path exists or cannot be written, or is a single file that ``settings`` would split.
        """
        self.path, self.start_ns = Path(path), start_ns
        self.prefix = prefix.rstrip("/")
        self._info = info
        self._settings = settings or RecordSettings()
        self._splits = self._settings.splits
        if is_mcap(self.path) and self._splits:
            raise InputError(f"{self.path} is a single file, which cannot be split: give a folder, without .mcap")
        self._topics: dict[str, Topic] = {}  # by the names of messages
        self._flushed_ns = self._end_ns = start_ns
        self._state = state
        self._note = ""
        self._open = True
        with creating(self.path), ExitStack() as undo:
            self._files = BagFiles(self.path)
            undo.callback(self._files.remove)
            self._begin_file()
            undo.pop_all()

    @property
    def file(self) -> Path:
        """The current file."""
        return self._file.path

    @property
    def bound(self) -> int:
        """Largest size of its files, bytes, if it is closed now."""
        return self._files.bound

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages that belong together; they stay in one chunk of the file."""
        together = [*messages]
        size = sum(len(message.cdr) for message in together)  # serialise all before one is taken: a Ctrl-C parts none
        with self._disk():
            if together and together[0].kind in BEGINNINGS:
                self._make_room(together[0].stamp_ns, size)
            for message in together:
                self._add(message)
            if self._end_ns - self._flushed_ns >= CHUNK_PERIOD_NS:
                self._file.flush()
                self._flushed_ns = self._end_ns

    def gap(self, note: str) -> None:
        """Mark a gap before the next messages; they go into another file if the bag is a folder.

        The state is repeated there, with the ``note``. Raises RecordingError if the disk refuses.
        """
        self._note = note
        if self._files.folder and self._file.holds_messages:
            self.split()

    def split(self) -> Path:
        """Finish the current file and continue in the next one of the folder, which is returned.

        Raises InputError, and continues as before, if the bag is no folder or the current file is empty;
        RecordingError if the disk refuses.
        """
        with self._disk():
            if not self._files.folder:
                raise InputError(f"{self.path} is a single file, which cannot be split: record into a folder")
            if not self._file.holds_messages:
                raise InputError(f"{self.file} holds nothing yet: split it later")
            self._begin_file()
        return self.file

    def snapshot(self) -> Path:
        """Raise InputError: the bag holds everything."""
        raise InputError(f"{self.path} records continuously: set record.mode to snapshot to take snapshots")

    def sync(self) -> None:
        """Wait until everything at the operating system is on the disk; RecordingError if the disk refuses."""
        with self._disk():
            self._files.sync()

    def close(self, *, sync: bool = False) -> None:
        """Finish the bag; with ``sync``, wait until it is on the disk."""
        if not self._open:
            return
        with self._disk():
            self._files.finish()
            if sync:
                self._files.sync()
        self._open = False

    def remove_if_empty(self) -> None:
        """Remove a closed bag without messages."""
        if not self._topics:
            self.remove()

    def remove(self) -> None:
        """Remove all files of a closed bag, and its folder unless it holds other files."""
        self._files.remove()

    def _begin_file(self) -> None:
        self._file = self._files.begin(self._end_ns, {METADATA_NAME: self._info.to_metadata()})
        self._state_due = True

    def _make_room(self, stamp_ns: int, more: int) -> None:
        """Begin another file, and remove the oldest ones, if the bounds require it before ``more`` bytes."""
        settings = self._settings
        if not self._splits:
            return
        full = 0 < settings.file_size < self._file.bound + more
        long = 0 < settings.max_duration * SECOND_NS <= stamp_ns - self._file.begin_ns
        if self._file.holds_messages and (full or long):
            self._begin_file()
        while self._files.finished and 0 < settings.max_total_size < self.bound + more:
            self._files.remove_oldest()

    def _add(self, message: Message) -> None:
        if message.kind == STATE:  # the next file begins with it
            self._state, self._state_due, of = message, False, message.fields
            self._info = self._info.with_input(Input(of["revision"], of["first_step"], of["scenario"]))
        elif (self._state_due or self._note) and message.kind in BEGINNINGS:
            self._repeat_state(message)
        topic = self._topics.get(message.topic)
        if topic is None:
            topic = self._topics[message.topic] = topic_of_node(self.prefix, message.topic, message.kind)
        self._file.add(topic, self._log_ns(message), message.cdr, published_ns=message.stamp_ns)
        self._end_ns = max(self._end_ns, message.end_ns)

    def _log_ns(self, message: Message) -> int:
        """When a message counts as logged, ns: at its stamp, but for the state with which a later file begins.

        That follows the file before at once, because the reader of rosbag2 seeks for ever in the time between two files
        (``SequentialReader::seek``: after the end of one, before the beginning of the other).
        """
        follows = self._files.follows_ns
        if message.kind != STATE or self._file.holds_messages or follows is None:
            return message.stamp_ns
        return min(message.stamp_ns, follows)

    def _repeat_state(self, chunk: Message) -> None:
        """Repeat the state before the first chunk of a file."""
        again = state_again(self._state, chunk, self._note) if self._state is not None else None
        self._note, self._state_due = "", False
        if again is not None:
            self._add(again)

    @contextmanager
    def _disk(self) -> Iterator[None]:
        """Require that the bag is open; finish it, as far as the disk allows, if the disk refuses."""
        if not self._open:
            raise RecordingError(f"{self.path} is closed: nothing more can be recorded in it")
        try:
            yield
        except OSError as reason:
            self._open = False
            self._files.abandon()
            raise RecordingError(
                f"{self.path} cannot be written further ({reason.strerror}): free space or give another path"
            ) from reason


@contextmanager
def creating(path: Path) -> Iterator[None]:
    """Turn any error that prevents creating ``path`` into an InputError in one line."""
    try:
        yield
    except OSError as reason:
        if isinstance(reason, FileExistsError) and path.exists():
            refusal = f"{path} exists already: give another path, or remove it first"
        else:
            why = "not a folder on the way" if isinstance(reason, FileExistsError) else reason.strerror
            refusal = f"{path} cannot be written ({why}): give a path in a folder that can be written"
        raise InputError(refusal) from None
