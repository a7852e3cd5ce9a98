"""Where the samples of a closed file are, and in which order, from the heads of its records.

A file may be closed and valid with a partial index: writers leave out chunk indexes, message indexes, or the repeated
definitions. So what the index says is completed from the file itself. https://mcap.dev/spec
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from .writer import MAGIC, RECORD

START = struct.Struct("<BQ")  # opcode, length
TIMES = struct.Struct("<QQ")  # of a chunk: first and last time
STAMP = struct.Struct("<HIQ")  # of a message: channel, sequence, log time
ENTRIES = struct.Struct("<HI")  # of a message index: channel, bytes of entries
INDEXED = struct.Struct("<QQQQI")  # of a chunk's index: first and last time, place and length, bytes of offsets
OFFSET = struct.Struct("<HQ")
LEAST = 22
"""Bytes of a message without data."""
HEAD = RECORD + TIMES.size
"""Bytes of a record that are looked at."""
LOOSE = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
"""Records of samples that may be outside of chunks."""
PASSED = (Opcode.HEADER, Opcode.MESSAGE_INDEX, Opcode.ATTACHMENT, Opcode.METADATA)
STRETCH = 1 << 20
"""Bytes of records outside of chunks that are read together."""
MOST_PASSED = 100_000
"""Records without samples in a row: more of them only take time."""
LARGEST_ENTRIES = 1 << 24
"""Bytes of the message indexes of a chunk."""
SPREAD = 10 * 10**9
"""Time, ns, by which parts may go back and are still read in the order of the file."""

Read = Callable[[int, int], bytes]
"""Bytes of the file: from a place on, so many."""


class FilePart(NamedTuple):
    """A chunk, or a stretch of records outside of chunks."""

    place: int
    """First byte in the file."""
    first_ns: int
    last_ns: int
    channels: frozenset[int]
    """Channels with messages in it; empty if nothing says so."""


@dataclass
class Layout:
    """The parts of a file with messages, in their order."""

    parts: list[FilePart] = field(default_factory=list)
    unordered: set[int] = field(default_factory=set)
    """Channels whose messages are not in the order of time."""
    timed: bool = True
    """Whether it says so of all channels: there is a message index after each chunk."""

    @property
    def channels(self) -> frozenset[int]:
        """All channels with messages."""
        return frozenset().union(*{part.channels for part in self.parts})

    @property
    def in_time(self) -> list[FilePart]:
        """Parts in the order in which they are read: that of the file, or of time if topics are stored apart."""
        latest = 0
        for part in self.parts:
            if part.first_ns < latest - SPREAD:
                return sorted(self.parts, key=lambda part: part.first_ns)
            latest = max(latest, part.first_ns)
        return self.parts


@dataclass
class Index:
    """The end of a closed file: what it repeats of the file."""

    place: int
    """First byte after the data."""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: dict[int, tuple[int, frozenset[int]]] = field(default_factory=dict)
    """By their places: bytes of the message indexes after them, channels with messages in them."""
    metadata: list[int] = field(default_factory=list)
    """Places of records of metadata."""
    counts: dict[int, int] | None = None
    """Messages of each channel; None if the file does not say."""

    def add_chunk(self, content: memoryview) -> None:
        """Note a chunk from its index record; raises struct.error for one that is too short."""
        _, _, place, _, size = INDEXED.unpack_from(content)
        end = INDEXED.size + size
        channels = frozenset(number for number, _ in OFFSET.iter_unpack(content[INDEXED.size : end]))
        (entries,) = struct.unpack_from("<Q", content, end)
        self.chunks[place] = entries, channels


def walk(read: Read, index: Index) -> Layout | None:
    """Where the samples of a closed file are; None if its records do not follow one another."""
    found = Layout()
    latest: dict[int, int] = {}

    def note(channel: int, times: tuple[int, ...]) -> None:
        if times and (list(times) != sorted(times) or times[0] < latest.get(channel, 0)):
            found.unordered.add(channel)
        latest[channel] = max(latest.get(channel, 0), *times)

    begun: dict[frozenset[int], frozenset[int]] = {}  # sets of channels, each kept once
    pending = False  # whether the last chunk has no message index yet
    for opcode, place, content in _heads(read, index):
        last = found.parts[-1] if found.parts else None
        if opcode is None:
            return None
        if opcode == Opcode.CHUNK:
            found.timed = found.timed and not pending
            pending = True
            channels = index.chunks[place][1] if place in index.chunks else frozenset()
            found.parts.append(_chunk_part(place, content, begun.setdefault(channels, channels)))
        elif opcode == Opcode.MESSAGE_INDEX and last:
            channel, times = _entries(content)
            note(channel, times)
            pending = pending and not times
            if channel not in last.channels:
                channels = last.channels | {channel}
                found.parts[-1] = last._replace(channels=begun.setdefault(channels, channels))
        elif opcode == Opcode.MESSAGE:
            channel, _, time = STAMP.unpack_from(content, RECORD)
            note(channel, (time,))
            if last is None or last.place != place:
                found.parts.append(FilePart(place, time, time, frozenset({channel})))
            else:
                span = min(last.first_ns, time), max(last.last_ns, time)
                found.parts[-1] = FilePart(place, *span, last.channels | {channel})
    found.timed = found.timed and not pending
    found.parts = [part for part in found.parts if part.channels or part.last_ns]
    return found


def _chunk_part(place: int, head: bytes, channels: frozenset[int]) -> FilePart:
    first, last = TIMES.unpack_from(head, RECORD)
    return FilePart(place, first, last, channels)


def stretch_end(read: Read, place: int, limit: int) -> int:
    """End of the records outside of chunks that begin at ``place``: of one at least, and of ``STRETCH`` bytes."""
    following = place
    while following < limit:
        opcode, length = START.unpack(read(following, RECORD).ljust(RECORD))
        end = following + RECORD + length
        if opcode not in LOOSE or end > limit or (following > place and end - place > STRETCH):
            break
        following = end
    return following


def _heads(read: Read, index: Index) -> Iterator[tuple[int | None, int, bytes]]:
    """Opcode, place and head of each record; opcode None where they end early.

    The place of a message is that of its stretch, which is as ``stretch_end`` cuts it. Message indexes are whole.
    """
    place, passed, begun = len(MAGIC), 0, 0
    while place < index.place:
        head = read(place, HEAD)
        opcode, length = START.unpack(head[:RECORD].ljust(RECORD))
        end = place + RECORD + length
        if opcode == Opcode.DATA_END:
            return
        known = opcode == Opcode.CHUNK or opcode in LOOSE or opcode in PASSED
        short = len(head) < HEAD or (opcode == Opcode.MESSAGE and length < LEAST)
        if not known or short or end > index.place or passed > MOST_PASSED:
            yield None, place, head
            return
        if opcode not in LOOSE:
            begun = 0
        elif not begun or end - begun > STRETCH:
            begun = place
        passed = 0 if opcode in (Opcode.CHUNK, Opcode.MESSAGE) else passed + 1
        if opcode == Opcode.MESSAGE_INDEX:
            head = read(place, RECORD + min(length, LARGEST_ENTRIES))
        yield opcode, (begun if opcode == Opcode.MESSAGE else place), head
        place = end


def _entries(record: bytes) -> tuple[int, tuple[int, ...]]:
    """Channel of a message index, and the times of its messages in their order in the chunk; none if it is damaged."""
    content = record[RECORD:]
    if len(content) < ENTRIES.size:
        return 0, ()
    channel, size = ENTRIES.unpack_from(content)
    places = [*TIMES.iter_unpack(content[ENTRIES.size : ENTRIES.size + size - size % TIMES.size])]
    return channel, tuple(time for time, _ in sorted(places, key=lambda place: place[1]))
