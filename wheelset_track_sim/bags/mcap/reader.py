"""Read an MCAP file without trusting any byte that no checksum covers.

The library's readers stop at the first bad byte and do not verify what an index says. This reader goes through a file
from its beginning. It yields chunks that are complete and have the right CRC. Between them it skips unreadable bytes up
to the next such chunk, and reports them as damage. Messages outside of chunks have no CRC of their own: they are read
unless that of the whole file is wrong. https://mcap.dev/spec
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, DataEnd, Header, McapRecord, Metadata, MetadataIndex, Schema, Statistics
from zstandard import ZstdError

from ..definitions import short_name
from ..losses import Damage
from ..topics import Topic
from .layout import ENTRIES, LEAST, LOOSE, MOST_PASSED, START, Index, Layout, stretch_end, walk
from .unpacking import COMPRESSIONS, LARGEST, ZSTD, unpacked, unpacked_message
from .writer import MAGIC, RECORD

CHUNK = struct.Struct("<BQQQQII")  # opcode, length; first and last time, size, CRC, length of the compression's name
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
FOOTER = struct.Struct("<BQQQI8s")  # opcode, length; summary, offsets, CRC; magic
DATA_END = struct.Struct("<BQI")  # opcode, length; CRC
CHUNK_START = re.compile(rb"(?s)\x06(?=.{24}(?!\0{8}).{12}(?:\x04\0\0\0zstd|\x03\0\0\0lz4|\0\0\0\0))")
"""Of a chunk that has data."""
CHECKED_START = re.compile(CHUNK_START.pattern.replace(rb".{12}", rb".{8}(?!\0{4}).{4}"))
"""Of one that has a CRC as well."""
OUTSIDE: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.MESSAGE_INDEX: None,
    Opcode.ATTACHMENT: Attachment,
    Opcode.METADATA: Metadata,
    Opcode.DATA_END: DataEnd,
}
"""Records between chunks."""
WINDOW = 1 << 20
"""Bytes that are searched at a time."""
MOST_RECORDS, RECORDS_PER_BYTE = 1_000_000, 0.25
"""Records that are read of a file: so many, and more by its size."""
MOST_BYTES, BYTES_PER_BYTE = 1 << 31, 1000
"""Bytes that a file is unpacked to: so many, and more by its size."""
LATEST = 2**64 - 1
"""Largest time that a record can have, ns."""
LARGEST_DEFINITION, MOST_DEFINITIONS = 1 << 20, 1 << 26
"""Bytes of the definition of a type or a topic, and of all that a file has."""
MOST_STARTS = 1_000_000
"""Places in a file that begin like a chunk and are none."""
MOST_DAMAGES = 1000
"""Damages of a file that are reported."""
UNREADABLE = (McapError, ZstdError, struct.error, ValueError, LookupError, RuntimeError, OverflowError)
"""Errors of the libraries for bytes that are not what they should be."""


@dataclass(frozen=True)
class Chunk:
    """Records that were written together: a chunk, or a stretch of records outside of chunks."""

    place: int
    """First byte in the file."""
    end: int
    """First byte after it."""
    data: bytes
    """Its records, decompressed."""


class StoredMessage(NamedTuple):
    """A message as a file holds it."""

    topic: Topic
    sequence: int
    log_time: int
    """ns"""
    publish_time: int
    """ns"""
    data: memoryview


class Span(NamedTuple):
    """Where messages are: a chunk, or a stretch of records outside of chunks."""

    place: int
    first_ns: int
    last_ns: int
    topics: frozenset[str]
    """Topics with messages in it; all topics of the file if nothing says which."""


@dataclass
class Known:
    """What has been found out about a file, for further readers of it."""

    size: int
    index: Index | None
    layout: Layout | None = None
    looked: bool = False
    """Whether ``layout`` has been looked for."""
    unordered: set[str] | None = None
    """Topics whose messages are not in the order of time; None if the file was not looked through for that."""
    disbelief: str | None = None
    """Why its messages outside of chunks are not read; empty if they are, None if that is not known yet."""


class McapReader:
    """Reads a stream, and leaves it open; of all errors in the file only OSError is raised."""

    def __init__(
        self, stream: BinaryIO, name: str, damaged: Callable[[Damage], object], known: Known | None = None
    ) -> None:
        """Read the index at the end of the file in ``stream``, unless it is ``known`` from another reader of it.

        Damage is reported to ``damaged`` under the ``name`` of the file.
        """
        self.name = name
        self._stream, self._damaged, self._damages = stream, damaged, 0
        self.size = stream.seek(0, 2)
        self.known = known if known and known.size == self.size else Known(self.size, self._read_index())
        index = self.known.index
        self._schemas = dict(index.schemas) if index else {}
        self._channels = dict(index.channels) if index else {}
        self._topics: dict[int, Topic] = {}
        self._definitions_left = MOST_DEFINITIONS
        self._set_limits()
        self._chunked = False
        """Whether a chunk has been found."""

    @property
    def index(self) -> Index | None:
        """The end of the file; None if it was not closed or its end is damaged."""
        return self.known.index

    @property
    def layout(self) -> Layout | None:
        """Where its samples are; None if it was not closed, or its records do not follow one another."""
        if not self.known.looked:
            self.known.looked = True
            try:
                self.known.layout = walk(self._read, self.index) if self.index else None
            except struct.error:
                self.known.layout = None
        return self.known.layout

    @property
    def topics(self) -> list[Topic]:
        """Topics in the order of their numbers: those that the index defines, and those read so far."""
        found = (self._topic(number) for number in sorted(self._channels))
        return [topic for topic in found if topic is not None]

    @property
    def lists_all(self) -> bool:
        """Whether topics, and the order of their messages, are known without looking through the file."""
        if self.index is None or self.layout is None or not self.layout.timed:
            return False
        defined = {n for n, channel in self.index.channels.items() if channel.schema_id in self.index.schemas}
        return self.layout.channels <= defined

    @property
    def unordered(self) -> set[str]:
        """Topics whose messages are known not to be in the order of time."""
        if self.known.unordered is not None:
            return self.known.unordered
        numbers = self.layout.unordered if self.layout else set()
        return {channel.topic for number, channel in self._channels.items() if number in numbers}

    @property
    def counts(self) -> dict[str, int] | None:
        """Messages of each topic by the file's own statistics; None if it has none. Definitions must be known."""
        if self.index is None or self.index.counts is None:
            return None
        found: dict[str, int] = {}
        for number, count in self.index.counts.items():
            if number in self._channels:
                name = self._channels[number].topic
                found[name] = found.get(name, 0) + count
        return found

    def scan(self) -> Iterator[Chunk | Metadata]:
        """Yield everything that can be read, in the order of the file."""
        if self.size == 0:
            self.report(0, 0, "it is empty")
            return
        self._set_limits()
        limit = self.index.place if self.index else self.size
        place, ended, passed = min(len(MAGIC), self.size), False, 0
        if self._read(0, len(MAGIC)) != MAGIC:
            self.report(0, place, "it does not begin as MCAP does")
        while place < limit and not ended:
            tiring = passed > MOST_PASSED
            found = f"more than {MOST_PASSED} records hold no samples" if tiring else self._record(place, limit)
            if isinstance(found, str):
                resumed = self._next_chunk(place, limit) if tiring else self._resumed(place, limit)
                self.report(place, resumed, found)
                place, passed = resumed, 0
                continue
            opcode, place, content = found
            ended = opcode == Opcode.DATA_END
            passed = 0 if isinstance(content, Chunk) and len(content.data) >= RECORD + LEAST else passed + 1
            if content is not None:
                yield content
        if self.index is None:
            self.report(place, self.size, "the index at the end is damaged" if ended else "it was not closed")

    def metadata(self) -> Iterator[Metadata]:
        """Records of metadata that the index lists."""
        for place in self.index.metadata if self.index else ():
            found = self._record(place, self.size)
            if not isinstance(found, str) and isinstance(found[2], Metadata):
                yield found[2]

    def spans(self) -> Iterator[Span]:
        """Where all messages are, in the order of the file; a file that does not say so is read for it."""
        if self.layout is not None and self.lists_all:
            named = {number: channel.topic for number, channel in self._channels.items()}
            everything = frozenset(named.values())
            for place, first, last, channels in self.layout.parts:
                topics = frozenset(named[number] for number in channels if number in named)
                yield Span(place, first, last, topics or everything)
            return
        yield from self.look_through()

    def look_through(self) -> Iterator[Span]:
        """Where all messages are, from the messages; ``topics`` and ``unordered`` are complete after it."""
        latest: dict[str, int] = {}
        unordered: set[str] = set()
        for part in self.scan():
            if not isinstance(part, Chunk):
                continue
            topics: set[str] = set()
            first, last = LATEST, 0
            for message in self.messages(part):
                name, time = message.topic.name, message.log_time
                if time < latest.get(name, 0):
                    unordered.add(name)
                latest[name] = max(time, latest.get(name, 0))
                topics.add(name)
                first, last = min(first, time), max(last, time)
            if topics:
                yield Span(part.place, first, last, frozenset(topics))
        self.known.unordered = unordered

    def release(self) -> None:
        """Free the memory of what ``spans`` and ``layout`` say, for a reader of ``chunks_at`` alone."""
        if self.index is not None:
            self.index.chunks.clear()
        self.known.layout, self.known.looked = None, True

    def chunks_at(self, places: Iterable[int]) -> Iterator[Chunk]:
        """Yield the chunks, and stretches of records, at places of ``spans`` or ``layout``."""
        self._set_limits()
        for place in places:
            found = self._record(place, self.index.place if self.index else self.size)
            if not isinstance(found, str) and isinstance(found[2], Chunk):
                yield found[2]
            else:
                self.report(place, place, found if isinstance(found, str) else "no chunk begins there")

    def messages(self, chunk: Chunk) -> Iterator[StoredMessage]:
        """Yield the messages of a chunk; messages of topics that were defined in a lost chunk are damage."""
        unknown = 0
        for opcode, content in _records(chunk.data):
            self._records_left -= 1
            if self._records_left < 0:
                self.report(chunk.place, chunk.end, "the file holds more records than one of its size can")
                return
            try:
                if opcode == Opcode.MESSAGE:
                    number, sequence, log_time, publish_time = MESSAGE.unpack_from(content)
                    topic = self._topics.get(number) or self._topic(number)
                    if topic is None:
                        unknown += 1
                    else:
                        data = content[MESSAGE.size :]
                        if data[:4] == ZSTD:
                            data = self._unpacked(data)
                        yield StoredMessage(topic, sequence, log_time, publish_time, data)
                elif opcode in LOOSE and len(content) > min(LARGEST_DEFINITION, self._definitions_left):
                    self.report(chunk.place, chunk.end, "a definition is too large, or the definitions of the file are")
                elif _register(opcode, content, self._schemas, self._channels):
                    self._definitions_left -= len(content)
                    self._topics.clear()
            except UNREADABLE:
                self.report(chunk.place, chunk.end, "a record in it is damaged")
        if unknown:
            self.report(chunk.place, chunk.end, f"{unknown} messages are of topics whose names are lost")

    def report(self, place: int, end: int, reason: str) -> None:
        """Report damage from byte ``place`` to before ``end``; the first ``MOST_DAMAGES`` are."""
        self._damages += 1
        if self._damages < MOST_DAMAGES:
            self._damaged(Damage(self.name, place, end, reason))
        elif self._damages == MOST_DAMAGES:
            self._damaged(Damage(self.name, place, end, f"{reason}; further damage is not listed"))

    def _unpacked(self, data: memoryview) -> memoryview:
        """A message that was compressed by itself; raises an error of ``UNREADABLE``."""
        found = unpacked_message(data, min(LARGEST, max(0, self._bytes_left)))
        self._bytes_left -= len(found)
        return memoryview(found)

    def _set_limits(self) -> None:
        """Allow as much work as a file of this size may ask for."""
        self._records_left = MOST_RECORDS + int(RECORDS_PER_BYTE * self.size)
        self._bytes_left = MOST_BYTES + BYTES_PER_BYTE * self.size
        self._starts_left = MOST_STARTS

    def _topic(self, number: int) -> Topic | None:
        channel = self._channels.get(number)
        schema = self._schemas.get(channel.schema_id) if channel else None
        if channel is None or schema is None:
            return None
        kind, encodings = short_name(schema.name), (schema.encoding, channel.message_encoding)
        topic = Topic(channel.topic, schema.name, kind, schema.data, channel.metadata, *encodings)
        self._topics[number] = topic
        return topic

    def _read(self, place: int, length: int) -> bytes:
        self._stream.seek(place)
        return self._stream.read(length)

    def _record(self, place: int, limit: int) -> tuple[int, int, Chunk | Metadata | None] | str:
        """Opcode, end and content of the record at a place, or what is wrong with it."""
        if limit - place < RECORD:
            return "the file ends there"
        opcode, length = START.unpack(self._read(place, RECORD))
        end = place + RECORD + length
        if opcode == Opcode.CHUNK:
            chunk = self._chunk(place, limit)
            return chunk if isinstance(chunk, str) else (opcode, chunk.end, chunk)
        if opcode not in OUTSIDE and opcode != Opcode.MESSAGE:
            return "no record begins there"
        if end > limit:
            return "the file ends within a record"
        if length > LARGEST:
            return f"a record has more than {LARGEST} bytes"
        if opcode in LOOSE:
            return self._stretch(place, limit)
        if opcode == Opcode.MESSAGE_INDEX:
            _, size = ENTRIES.unpack(self._read(place + RECORD, ENTRIES.size).ljust(ENTRIES.size))
            return (opcode, end, None) if length == ENTRIES.size + size else "a record is damaged"
        record = _parsed(OUTSIDE[opcode], self._read(place, RECORD + length))
        if record is None:
            return "a record is damaged"
        return opcode, end, record if isinstance(record, Metadata) else None

    def _stretch(self, place: int, limit: int) -> tuple[int, int, Chunk | None] | str:
        """Records outside of chunks, from ``place`` on, or why they are not read."""
        end = stretch_end(self._read, place, limit)
        data = self._read(place, end - place)
        opcodes = [opcode for opcode, content in _records(data) if opcode != Opcode.MESSAGE or len(content) >= LEAST]
        whole = all(
            _parsed(OUTSIDE[opcode], START.pack(opcode, len(content)) + bytes(content))
            for opcode, content in _records(data)
            if opcode != Opcode.MESSAGE
        )
        if not whole or len(opcodes) < sum(1 for _ in _records(data)):
            return "a record is damaged"
        disbelief = self._disbelief()
        if disbelief and Opcode.MESSAGE in opcodes:
            return disbelief
        return Opcode.MESSAGE, end, None if disbelief else Chunk(place, end, data)

    def _disbelief(self) -> str:
        """Why messages outside of chunks are not read; empty if they are."""
        if self.index is None:  # nothing says that a chunk whose beginning is damaged is none
            return "messages outside of chunks have no checksum" if self._chunked else ""
        if self.known.disbelief is None:
            end = self.index.place - DATA_END.size
            opcode, _, crc = DATA_END.unpack(self._read(end, DATA_END.size).ljust(DATA_END.size))
            right = opcode != Opcode.DATA_END or crc in (0, self._crc(end))
            self.known.disbelief = "" if right else "messages outside of chunks, and the checksum of the file is wrong"
        return self.known.disbelief

    def _crc(self, end: int) -> int:
        """CRC of everything before ``end``."""
        crc = 0
        for place in range(0, end, WINDOW):
            crc = zlib.crc32(self._read(place, min(WINDOW, end - place)), crc)
        return crc

    def _chunk(self, place: int, limit: int) -> Chunk | str:
        """The chunk at a place, or what is wrong with it."""
        head = self._read(place, CHUNK.size + 12)
        if len(head) < CHUNK.size + 12:
            return "the file ends within a chunk"
        opcode, length, _, _, size, crc, named = CHUNK.unpack_from(head)
        packed = int.from_bytes(head[CHUNK.size + named :][:8], "little")
        end = place + RECORD + length
        compression = head[CHUNK.size :][:named]
        if opcode != Opcode.CHUNK or compression not in COMPRESSIONS or place + CHUNK.size + named + 8 + packed != end:
            return "the beginning of a chunk is damaged"
        if end > limit:
            return "the file ends within a chunk"
        if max(packed, size) > LARGEST:
            return f"a chunk has more than {LARGEST} bytes"
        if crc == 0 and self.index is None:
            return "a chunk has no checksum that would show that it is whole"
        self._bytes_left -= size
        if self._bytes_left < 0:
            return "the file unpacks to more bytes than one of its size can"
        try:
            data = unpacked(compression, self._read(end - packed, packed), size)
        except UNREADABLE as reason:
            return f"a chunk is damaged ({' '.join(str(reason).split())})"
        if crc not in (0, zlib.crc32(data)):
            return "a chunk is damaged (its checksum is wrong)"
        self._chunked = True
        return Chunk(place, end, data)

    def _resumed(self, place: int, limit: int) -> int:
        """Where reading continues after a damaged record: at its end if a whole one follows, else at the next chunk."""
        if place + RECORD <= limit:
            _, length = START.unpack(self._read(place, RECORD))
            end = place + RECORD + int(length)
            if end < limit and not isinstance(self._record(end, limit), str):
                return end
        return self._next_chunk(place + 1, limit)

    def _next_chunk(self, place: int, limit: int) -> int:
        """Where the next whole chunk with data begins; ``limit`` if there is none."""
        start = CHUNK_START if self.index else CHECKED_START
        while place < limit:
            window = self._read(place, min(WINDOW + CHUNK.size + 12, limit - place))
            for found in start.finditer(window):
                self._starts_left -= 1
                if self._starts_left < 0:
                    return limit
                if isinstance(self._chunk(place + found.start(), limit), Chunk):
                    return place + found.start()
            place += WINDOW
        return limit

    def _read_index(self) -> Index | None:
        """The index, if it and all before it can have been written to the end."""
        before = self.size - FOOTER.size
        if before < len(MAGIC):
            return None
        opcode, length, start, _, crc, magic = FOOTER.unpack(self._read(before, FOOTER.size))
        if (opcode, length, magic) != (Opcode.FOOTER, FOOTER.size - RECORD - len(MAGIC), MAGIC):
            return None
        start = start or before  # a file may be closed without an index
        if not len(MAGIC) <= start <= before or before - start > LARGEST:
            return None
        summary = self._read(start, before + FOOTER.size - len(MAGIC) - 4 - start)
        if crc not in (0, zlib.crc32(summary)):
            return None
        index = Index(start)
        try:
            for opcode, content in _records(summary[: before - start]):
                _index(index, opcode, content)
        except UNREADABLE:
            return None
        return index


def _index(index: Index, opcode: int, content: memoryview) -> None:
    """Note a record of the end of a file."""
    if opcode == Opcode.CHUNK_INDEX:
        index.add_chunk(content)
    elif opcode == Opcode.METADATA_INDEX:
        index.metadata.append(MetadataIndex.read(_stream_of(content)).offset)
    elif opcode == Opcode.STATISTICS:
        index.counts = Statistics.read(_stream_of(content)).channel_message_counts
    else:
        _register(opcode, content, index.schemas, index.channels)


def _records(data: bytes) -> Iterator[tuple[int, memoryview]]:
    """Opcode and content of records, as far as they are complete."""
    view, place = memoryview(data), 0
    while place + RECORD <= len(view):
        opcode, length = START.unpack_from(view, place)
        place += RECORD + length
        if place > len(view):
            return
        yield opcode, view[place - length : place]


def _stream_of(content: bytes | memoryview) -> ReadDataStream:
    """A record's content as the library reads it."""
    return ReadDataStream(BytesIO(content))


def _register(opcode: int, content: memoryview, schemas: dict[int, Schema], channels: dict[int, Channel]) -> bool:
    """Note the definition of a type or a topic; whether it is another one than before."""
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(_stream_of(content))
        known = schemas.get(schema.id)
        schemas[schema.id] = schema
        return known is None or bool(known != schema)
    if opcode == Opcode.CHANNEL:
        channel = Channel.read(_stream_of(content))
        before = channels.get(channel.id)
        channels[channel.id] = channel
        return before is None or bool(before != channel)
    return False


def _parsed(kind: Any, data: bytes) -> McapRecord | None:
    """A record whose lengths are right: writing it again gives the same bytes."""
    try:
        record: McapRecord = kind.read(_stream_of(data[RECORD:]))
        builder: Any = RecordBuilder()
        record.write(builder)
    except UNREADABLE:
        return None
    return record if bytes(builder.end()) == data else None
