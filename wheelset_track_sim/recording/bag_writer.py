"""Bags as ``ros2 bag`` reads them, written without ROS: MCAP with CDR messages and zstd chunks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, BinaryIO

from .. import __version__
from ..errors import InputError, RecordingError
from ..simulation.block import SampleBlock
from ..simulation.impacts import Impact
from ..simulation.summary import Summary
from ..simulation.turns import NO_TURN, TurnPeaks
from .definitions import full_name, schema
from .inputs import Input
from .mcap_file import McapFile
from .messages import Message, State, chunk_messages, impact_message, state_message
from .rosbag2_metadata import LATCHED_TOPICS, Part, Topic, channel_metadata, write_folder_metadata
from .run_info import METADATA_NAME, RunInfo

if TYPE_CHECKING:
    from typing_extensions import Self

PREFIX = "/wheelset_track_sim"
CHUNK_PERIOD_NS = 100_000_000
"""A chunk of the file is closed after this time of the run: what a crash can lose."""


class BagWriter:
    """One bag while it is written; a context manager that leaves a readable bag, also after an exception.

    A path that ends in ``.mcap`` is one file, any other a bag folder with ``metadata.yaml`` and files that ``split``
    begins, each of which can be read alone. An exception before the first message leaves nothing behind.
    """

    def __init__(self, path: str | Path, info: RunInfo, *, start_ns: int, prefix: str = PREFIX) -> None:
        """Create the bag; ``start_ns`` is the time stamp of step 0, ns since the epoch.

        Raises InputError if the path exists or cannot be written.
        """
        self.path = Path(path)
        self.start_ns = start_ns
        self.prefix = prefix.rstrip("/")
        self._info = info
        self._folder = None if self.path.suffix == ".mcap" else self.path
        self._topics: dict[str, Topic] = {}
        self._parts: list[Part] = []
        self._chunk_ns = self._last_ns = start_ns
        self._open = True
        try:
            if self._folder is None:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            else:
                self._folder.mkdir(parents=True)
            self._begin()
        except OSError as reason:
            if isinstance(reason, FileExistsError) and self.path.exists():
                refusal = f"{self.path} exists already: give another path, or remove it first"
            else:
                why = "not a folder on the way" if isinstance(reason, FileExistsError) else reason.strerror
                refusal = f"{self.path} cannot be written ({why}): give a path in a folder that can be written"
            raise InputError(refusal) from None

    @property
    def file(self) -> Path:
        """The file at hand."""
        return self.path if self._folder is None else self._folder / self._parts[-1].name

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        with suppress(RecordingError):  # the first error is the one to tell
            self.close()
        if not self._topics:
            self._remove()

    def write(
        self,
        block: SampleBlock,
        *,
        real_time_factor: float = math.nan,
        lag: float = 0.0,
        summary: Summary | None = None,
        turn: TurnPeaks = NO_TURN,
        impacts: Iterable[Impact] = (),
    ) -> None:
        """Record one block with the ``impacts`` that were over in it; RecordingError if the disk refuses.

        ``summary`` is that of the block if it is known already, ``turn`` the last complete turn of the wheels.
        """
        messages = chunk_messages(
            block, self.start_ns, real_time_factor=real_time_factor, lag=lag, summary=summary, turn=turn
        )
        self.write_messages(messages)
        self.write_impacts(impacts)

    def write_impacts(self, impacts: Iterable[Impact]) -> None:
        """Record impacts; RecordingError if the disk refuses."""
        self.write_messages(impact_message(impact, self.start_ns) for impact in impacts)

    def write_state(self, state: State) -> None:
        """Record what is simulated from a step on: at the start, and at every revision."""
        self.write_messages([state_message(state, self.start_ns)])

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages that belong together; they stay in one chunk of the file."""
        if not self._open:
            raise RecordingError(f"{self.path} is closed: nothing more can be recorded in it")
        try:
            for message in messages:
                self._add(message)
            if self._last_ns - self._chunk_ns >= CHUNK_PERIOD_NS:
                self._mcap.flush()
                self._chunk_ns = self._last_ns
        except OSError as reason:
            raise self._refused(reason) from reason

    def split(self) -> Path:
        """Finish the file at hand and go on in the next one of the folder, which is returned.

        Raises InputError, and goes on as before, if the bag is no folder or the file at hand is empty; RecordingError
        if the disk refuses.
        """
        if not self._open:
            raise RecordingError(f"{self.path} is closed: nothing more can be recorded in it")
        if self._folder is None:
            raise InputError(f"{self.path} is a single file, which cannot be split: record into a folder")
        if self._parts[-1].count == 0:
            raise InputError(f"{self.file} holds nothing yet: split it later")
        before, stream = self._mcap, self._stream
        try:
            with stream:
                before.finish()
            self._begin()
        except OSError as reason:
            self._open = False
            raise self._refused(reason) from reason
        return self.file

    def close(self) -> None:
        """Finish the bag; closing again does nothing. Raises RecordingError if the disk refuses."""
        if not self._open:
            return
        self._open = False
        try:
            with self._stream:
                self._mcap.finish()
            self._write_folder_metadata()
        except OSError as reason:
            raise self._refused(reason) from reason

    def _begin(self) -> None:
        """Begin the next file; raises OSError."""
        name = self.path.name if self._folder is None else f"{self.path.name}_{len(self._parts)}.mcap"
        self._stream: BinaryIO = (self.path if self._folder is None else self._folder / name).open("xb")
        self._parts.append(Part(name, self._last_ns, self._last_ns))
        self._mcap = McapFile(self._stream, "ros2", f"wheelset_track_sim {__version__}")
        self._mcap.add_metadata(METADATA_NAME, self._info.to_metadata())
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._write_folder_metadata()

    def _add(self, message: Message) -> None:
        channel = self._channels.get(message.topic) or self._register(message)
        topic = self._topics[message.topic]
        if message.kind == "SimulationState":  # what the next file begins with
            of = message.fields
            self._info = self._info.with_input(Input(of["revision"], of["first_step"], of["scenario"]))
        self._last_ns = max(self._last_ns, message.stamp_ns)
        self._mcap.add_message(channel, message.stamp_ns, topic.count, message.cdr)
        topic.count += 1
        self._parts[-1].add(message.stamp_ns)

    def _register(self, message: Message) -> int:
        """Number of a topic in the file at hand."""
        kind = message.kind
        if kind not in self._schemas:
            self._schemas[kind] = self._mcap.add_schema(full_name(kind), "ros2msg", schema(kind).encode())
        topic = self._topics.get(message.topic)
        if topic is None:
            topic = Topic(f"{self.prefix}/{message.topic}", kind, latched=message.topic in LATCHED_TOPICS)
            self._topics[message.topic] = topic
        channel = self._mcap.add_channel(topic.name, "cdr", self._schemas[kind], channel_metadata(topic))
        self._channels[message.topic] = channel
        return channel

    def _write_folder_metadata(self) -> None:
        if self._folder is not None:
            write_folder_metadata(self._folder, self._parts, [*self._topics.values()])

    def _remove(self) -> None:
        self.file.unlink(missing_ok=True)
        if self._folder is not None:
            (self._folder / "metadata.yaml").unlink(missing_ok=True)
            self._folder.rmdir()

    def _refused(self, reason: OSError) -> RecordingError:
        return RecordingError(
            f"{self.path} cannot be written further ({reason.strerror}): free space or give another path"
        )
