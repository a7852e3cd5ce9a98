"""One file of a bag while it is written."""

from __future__ import annotations

import errno
import os
from collections import Counter
from contextlib import suppress
from io import FileIO
from pathlib import Path

from ..version import __version__
from .definitions import full_name, schema
from .mcap.writer import McapFile
from .messages import Message
from .rosbag2_metadata import LATCHED_TOPICS, Part, Topic
from .run_info import METADATA_NAME, RunInfo

NO_DISK = (errno.EINVAL, errno.ENOTSUP)
"""Errors that tell that there is nothing which could be waited for."""


class BagFile:
    """An MCAP file of ROS messages that says of which run it is; all methods raise OSError if the disk refuses."""

    def __init__(self, path: Path, info: RunInfo, prefix: str, begin_ns: int) -> None:
        """Create ``path``, which must not exist; ``prefix`` stands before the topics."""
        self.path = path
        self.begin_ns = begin_ns
        """Time stamp of the first message, ns; ``begin_ns`` before there is one."""
        self.topics: dict[str, Topic] = {}
        """By the names of messages, in the order in which they came."""
        self._prefix = prefix
        self._stream = FileIO(path, "xb")
        try:
            self._mcap = McapFile(self._stream, "ros2", f"wheelset_track_sim {__version__}")
            self._mcap.add_metadata(METADATA_NAME, info.to_metadata())
        except OSError:
            self._stream.close()
            path.unlink(missing_ok=True)
            raise
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._sequence: Counter[int] = Counter()

    @property
    def size(self) -> int:
        """Bytes written."""
        return self._mcap.place

    @property
    def bound(self) -> int:
        """Bytes that it has at most if it is finished now."""
        return self._mcap.bound

    @property
    def holds_messages(self) -> bool:
        """Whether there are any, written or not."""
        return self._mcap.holds_messages

    @property
    def part(self) -> Part:
        """What is written."""
        found = self._mcap.statistics()
        names = {self._channels[topic]: item.name for topic, item in self.topics.items()}
        counts = {names[number]: count for number, count in found.channel_message_counts.items()}
        times = (found.message_start_time, found.message_end_time) if counts else (self.begin_ns, self.begin_ns)
        return Part(self.path.name, *times, counts, self.size)

    def add(self, message: Message) -> None:
        """Take in a message; it is written with the next ``flush``."""
        channel = self._channels.get(message.topic) or self._register(message)
        if not self.holds_messages:
            self.begin_ns = message.stamp_ns
        self._mcap.add_message(channel, message.stamp_ns, self._sequence[channel], message.cdr)
        self._sequence[channel] += 1

    def flush(self) -> None:
        """Hand all messages over to the operating system: there they outlive this process."""
        self._mcap.flush()
        self._require_name()

    def sync(self) -> None:
        """Wait until what was handed over is on the disk: there it outlives a power failure."""
        try:
            os.fdatasync(self._stream.fileno())
        except OSError as reason:
            if reason.errno not in NO_DISK:
                raise

    def finish(self) -> None:
        """Write what is at hand and the index, and close; finishing again does nothing."""
        if not self._stream.closed:
            self._mcap.finish()
            self._require_name()
            self._stream.close()

    def abandon(self) -> None:
        """Close where the disk refuses: the index may find the room that the last chunk did not."""
        with suppress(OSError):
            self.finish()
        with suppress(OSError):
            self._stream.close()

    def _require_name(self) -> None:
        """Raise OSError if the file has no name any more: its bytes would go to nowhere without a word."""
        if os.fstat(self._stream.fileno()).st_nlink == 0:
            raise FileNotFoundError(errno.ENOENT, f"{self.path.name} has been removed")

    def _register(self, message: Message) -> int:
        """Number of the channel of a new topic."""
        kind = message.kind
        if kind not in self._schemas:
            self._schemas[kind] = self._mcap.add_schema(full_name(kind), "ros2msg", schema(kind).encode())
        topic = Topic.of(f"{self._prefix}/{message.topic}", kind, latched=message.topic in LATCHED_TOPICS)
        channel = self._mcap.add_channel(topic.name, "cdr", self._schemas[kind], topic.metadata)
        self.topics[message.topic], self._channels[message.topic] = topic, channel
        return channel
