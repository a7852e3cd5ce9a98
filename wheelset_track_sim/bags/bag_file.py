"""The files of a bag while they are written."""

from __future__ import annotations

import errno
import os
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path

from ..runtime.output_files import file_name
from ..version import __version__
from .folder_files import is_mcap
from .folder_metadata import METADATA, BagPart, write_folder_metadata
from .mcap.writer import McapWriter
from .topics import Topic

NO_DISK = (errno.EINVAL, errno.ENOTSUP)
"""Errors of a stream that is no file on a disk: there is nothing to wait for."""


class BagFile:
    """An MCAP file of ROS messages; all methods raise OSError if the disk refuses."""

    def __init__(self, path: Path, begin_ns: int, records: Mapping[str, Mapping[str, str]]) -> None:
        """Create ``path``, which must not exist, with ``records`` of metadata by name."""
        self.path = path
        self.begin_ns = begin_ns
        """When the first message was published, ns; ``begin_ns`` before there is one."""
        self._stream = FileIO(path, "xb")
        try:
            self._mcap = McapWriter(self._stream, "ros2", f"wheelset_track_sim {__version__}")
            for name, record in records.items():
                self._mcap.add_metadata(name, record)
        except OSError:
            self._stream.close()
            path.unlink(missing_ok=True)
            raise
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channels: dict[Topic, int] = {}
        self._sequence: Counter[int] = Counter()

    @property
    def size(self) -> int:
        """Bytes written."""
        return self._mcap.place

    @property
    def bound(self) -> int:
        """Largest size, bytes, if it is finished now."""
        return self._mcap.bound

    @property
    def holds_messages(self) -> bool:
        """Whether there are any, written or not."""
        return self._mcap.holds_messages

    @property
    def topics(self) -> tuple[Topic, ...]:
        """Topics of its messages, in the order of the first ones."""
        return tuple(self._channels)

    @property
    def part(self) -> BagPart:
        """Everything written so far."""
        found = self._mcap.statistics()
        counts: Counter[str] = Counter()
        for topic, channel in self._channels.items():
            counts[topic.name] += found.channel_message_counts.get(channel, 0)
        times = (found.message_start_time, found.message_end_time) if counts.total() else (self.begin_ns,) * 2
        return BagPart(self.path.name, *times, counts, self.size)

    def add(
        self,
        topic: Topic,
        time_ns: int,
        cdr: bytes | memoryview,
        *,
        sequence: int | None = None,
        published_ns: int | None = None,
    ) -> None:
        """Take a message, which is written with the next ``flush``.

        Without ``sequence`` it has the next number of its topic, without ``published_ns`` it was published at
        ``time_ns``.
        """
        channel = self._channels.get(topic) or self._register(topic)
        if not self.holds_messages:
            self.begin_ns = time_ns if published_ns is None else published_ns
        number = self._sequence[channel] if sequence is None else sequence
        self._mcap.add_message(channel, time_ns, number, cdr, published=published_ns)
        self._sequence[channel] += 1

    def flush(self) -> None:
        """Hand all messages over to the operating system, where they outlive this process."""
        self._mcap.flush()
        self._require_name()

    def sync(self) -> None:
        """Wait until everything flushed is on the disk; the name of the file may be not."""
        with _of_disks():
            os.fdatasync(self._stream.fileno())

    def finish(self) -> None:
        """Write the messages at hand and the index, and close; finishing again does nothing."""
        if not self._stream.closed:
            self._mcap.finish()
            self._require_name()
            self._stream.close()

    def abandon(self) -> None:
        """Close after the disk refused: the index may fit where the last chunk did not."""
        with suppress(OSError):
            self.finish()
        with suppress(OSError):
            self._stream.close()

    def _require_name(self) -> None:
        """Raise OSError if the file has been removed: its bytes would be lost without an error."""
        if os.fstat(self._stream.fileno()).st_nlink == 0:
            raise FileNotFoundError(errno.ENOENT, f"{self.path.name} has been removed")

    def _register(self, topic: Topic) -> int:
        """Number of the channel of a new topic."""
        of = topic.type, topic.definition
        if of not in self._schemas:
            self._schemas[of] = self._mcap.add_schema(topic.type, topic.encoding, topic.definition)
        channel = self._mcap.add_channel(topic.name, topic.message_encoding, self._schemas[of], topic.metadata)
        self._channels[topic] = channel
        return channel


class BagFiles:
    """One file if the path ends in ``.mcap``, otherwise a folder of files with ``metadata.yaml``.

    All methods raise OSError if the disk refuses.
    """

    def __init__(self, path: Path) -> None:
        """Create the folder, which must not exist, or the folders above a single file."""
        self.path = path
        self.folder = not is_mcap(path)
        if self.folder:
            path.mkdir(parents=True)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
        self.finished: list[BagPart] = []
        self.current: BagFile | None = None
        self._begun = 0
        self._topics: dict[str, Topic] = {}
        self._unsynced = {path.parent}

    @property
    def follows_ns(self) -> int | None:
        """Time right after the last message of the file before, ns; None for the first file."""
        return self.finished[-1].last_ns + 1 if self.finished else None

    @property
    def bound(self) -> int:
        """Largest size of all files, bytes, if they are finished now."""
        return sum(part.size for part in self.finished) + (self.current.bound if self.current else 0)

    def begin(self, begin_ns: int, records: Mapping[str, Mapping[str, str]]) -> BagFile:
        """Finish the current file, and begin another one."""
        before = self.current
        if before is not None:
            before.finish()
        file = BagFile(self._path_of(f"{file_name(self.path.name)}_{self._begun}.mcap"), begin_ns, records)
        self._end_current()
        self.current, self._begun = file, self._begun + 1
        self._unsynced.add(file.path.parent)
        self._write_metadata()
        return file

    def sync(self) -> None:
        """Wait until everything flushed is on the disk, with the names of the files: it outlives a power failure."""
        if self.current is not None:
            self.current.sync()
        for path in sorted(self._unsynced, key=lambda path: path.is_dir()):  # contents before names
            with suppress(FileNotFoundError), _of_disks():  # the oldest ones are removed
                opened = os.open(path, os.O_RDONLY)
                try:
                    os.fsync(opened)
                finally:
                    os.close(opened)
        self._unsynced.clear()

    def finish(self) -> None:
        """Finish the current file; finishing again does nothing."""
        if self.current is not None:
            self.current.finish()
            self._end_current()
            self._write_metadata()

    def abandon(self) -> None:
        """Finish as far as the disk allows, after it refused; raises nothing."""
        if self.current is not None:
            self.current.abandon()
            self._end_current()
        with suppress(OSError):
            self._write_metadata()

    def remove_oldest(self) -> None:
        """Remove the file that was finished first."""
        oldest = self.finished.pop(0)
        self._write_metadata()
        self._path_of(oldest.name).unlink(missing_ok=True)

    def remove(self) -> None:
        """Remove all files, and the folder unless it holds others."""
        self.abandon()
        for part in self.finished:
            self._path_of(part.name).unlink(missing_ok=True)
        if self.folder:
            (self.path / METADATA).unlink(missing_ok=True)
            with suppress(OSError):
                self.path.rmdir()

    def _path_of(self, name: str) -> Path:
        return self.path / name if self.folder else self.path

    def _end_current(self) -> None:
        if self.current is not None:
            self.finished.append(self.current.part)
            self._unsynced.add(self.current.path)
            self._note_topics(self.current)
            self.current = None

    def _write_metadata(self) -> None:
        parts = [*self.finished]
        if self.current is not None:
            parts.append(self.current.part)
            self._note_topics(self.current)
        if self.folder and parts:
            write_folder_metadata(self.path, parts, [*self._topics.values()])
            self._unsynced |= {self.path / METADATA, self.path}

    def _note_topics(self, file: BagFile) -> None:
        for topic in file.topics:
            self._topics.setdefault(topic.name, topic)


@contextmanager
def _of_disks() -> Iterator[None]:
    """Leave streams alone that are no files on a disk."""
    try:
        yield
    except OSError as reason:
        if reason.errno not in NO_DISK:
            raise
