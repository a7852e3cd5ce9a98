"""A bag of messages as they are: their bytes, definitions, topics and times are those of another bag."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from io import FileIO
from pathlib import Path

from mcap.records import Channel, Metadata, Schema

from ..errors import InputError
from ..version import __version__
from .mcap.records import Message
from .mcap.writer import McapFile
from .rosbag2_metadata import METADATA, Part, Topic, write_folder_metadata


class BagCopy:
    """One file if its path ends in ``.mcap``, otherwise a folder; all methods raise OSError if the disk refuses."""

    def __init__(self, path: Path) -> None:
        """Nothing is written before the first chunk; InputError if the path exists."""
        if path.exists():
            raise InputError(f"{path} exists already: give another path, or remove it first")
        self.path = path
        self.chunks = self.messages = 0
        """That were written."""
        self._folder = path.suffix != ".mcap"
        self._made: list[Path] = []
        self._file: _CopyFile | None = None
        self._parts: list[Part] = []
        self._topics: dict[str, Topic] = {}

    def begin(self) -> None:
        """Go on in another file of the folder."""
        if self._folder:
            self._end_file()

    def write(self, messages: Iterable[Message], info: Metadata | None) -> None:
        """Write messages as one chunk, with the metadata ``info`` where a file begins."""
        if self._file is None:
            self._file = self._begin_file(info)
        self.messages += self._file.write(messages)
        self.chunks += 1

    def finish(self) -> None:
        """Finish the bag."""
        self._end_file()
        if self._folder and self._parts:
            self._made.append(self.path / METADATA)
            write_folder_metadata(self.path, self._parts, [*self._topics.values()])

    def remove(self) -> None:
        """Remove all that was written."""
        if self._file is not None:
            self._file.stream.close()
        for path in reversed(self._made):
            path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)

    def _begin_file(self, info: Metadata | None) -> _CopyFile:
        if not self._parts:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if self._folder:
                self.path.mkdir()
                self._made.append(self.path)
        path = self.path / f"{self.path.name}_{len(self._parts)}.mcap" if self._folder else self.path
        file = _CopyFile(path, info)
        self._made.append(path)
        return file

    def _end_file(self) -> None:
        if self._file is not None:
            self._file.mcap.finish()
            self._file.stream.close()
            self._parts.append(self._file.part())
            self._topics |= self._file.topics
            self._file = None


class _CopyFile:
    def __init__(self, path: Path, info: Metadata | None) -> None:
        self.stream = FileIO(path, "xb")
        self.mcap = McapFile(self.stream, "ros2", f"wheelset_track_sim {__version__}")
        self.topics: dict[str, Topic] = {}
        self._path = path
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channels: dict[tuple[str, int], int] = {}
        if info is not None:
            self.mcap.add_metadata(info.name, info.metadata)

    def write(self, messages: Iterable[Message]) -> int:
        count = 0
        for count, message in enumerate(messages, start=1):  # noqa: B007 - the last one is the number of messages
            channel = self._channel(message.schema, message.channel)
            self.mcap.add_message(
                channel, message.log_time, message.sequence, message.data, published=message.publish_time
            )
        self.mcap.flush()
        return count

    def part(self) -> Part:
        found = self.mcap.statistics()
        counts: Counter[str] = Counter()
        for (topic, _), number in self._channels.items():
            counts[topic] += found.channel_message_counts.get(number, 0)
        return Part(self._path.name, found.message_start_time, found.message_end_time, counts, self.mcap.place)

    def _channel(self, schema: Schema, channel: Channel) -> int:
        of = schema.name, schema.data
        if of not in self._schemas:
            self._schemas[of] = self.mcap.add_schema(schema.name, schema.encoding, schema.data)
        key = channel.topic, self._schemas[of]
        if key not in self._channels:
            self._channels[key] = self.mcap.add_channel(
                channel.topic, channel.message_encoding, self._schemas[of], channel.metadata
            )
            self.topics.setdefault(channel.topic, Topic(channel.topic, schema.name, channel.metadata))
        return self._channels[key]
