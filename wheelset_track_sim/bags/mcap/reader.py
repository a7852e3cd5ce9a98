"""Read an MCAP file without trusting any byte that no checksum covers.

The library's readers stop at the first bad byte and do not verify what an index says. This reader goes through a file
from its beginning. It yields chunks that are complete and have the right CRC. Between them it skips unreadable bytes up
to the next such chunk, and reports them as damage. https://mcap.dev/spec
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, ChunkIndex, DataEnd, Header, McapRecord, Metadata, Schema
from mcap.records import Chunk as McapChunk
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

from ..definitions import short_name
from ..losses import Damage
from ..topics import Topic
from .writer import MAGIC, RECORD

START = struct.Struct("<BQ")  # opcode, length
CHUNK = struct.Struct("<BQQQQII")  # opcode, length; first and last time, size, CRC, length of the compression's name
MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
FOOTER = struct.Struct("<BQQQI8s")  # opcode, length; summary, offsets, CRC; magic
CHUNK_START = re.compile(rb"(?s)\x06(?=.{36}(?:\x04\0\0\0zstd|\x03\0\0\0lz4|\0\0\0\0))")
ENTRIES = struct.Struct("<HI")  # of a message index: channel, bytes of entries
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
COMPRESSIONS = (b"", b"lz4", b"zstd")
WINDOW = 1 << 20
"""Bytes that are searched at a time."""
LARGEST = 1 << 30
"""Largest record that is read, bytes."""
UNREADABLE = (McapError, ZstdError, struct.error, ValueError, LookupError, RuntimeError, MemoryError, OverflowError)
"""Errors of the libraries for bytes that are not what they should be."""


@dataclass(frozen=True)
class Chunk:
    """A chunk with the bytes that were written."""

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
    """A chunk as the index describes it."""

    place: int
    first_ns: int
    last_ns: int
    topics: frozenset[str]
    """Topics with messages in it; all topics of the file if the index does not list them."""


@dataclass
class Index:
    """The index at the end of a file that was closed."""

    place: int
    """First byte after the chunks."""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)


class McapReader:
    """Reads a stream, and leaves it open; of all errors in the file only OSError is raised."""

    def __init__(self, stream: BinaryIO, name: str, damaged: Callable[[Damage], object]) -> None:
        """Read the index at the end of the file in ``stream``.

        Damage is reported to ``damaged`` under the ``name`` of the file.
        """
        self.name = name
        self._stream, self._damaged = stream, damaged
        self.size = stream.seek(0, 2)
        self.index = self._read_index()
        """None if the file was not closed or its end is damaged."""
        self._schemas = dict(self.index.schemas) if self.index else {}
        self._channels = dict(self.index.channels) if self.index else {}
        self._topics: dict[int, Topic] = {}

    @property
    def topics(self) -> list[Topic]:
        """Topics in the order of their numbers; without an index, only topics of the chunks that have been read."""
        found = (self._topic(number) for number in sorted(self._channels))
        return [topic for topic in found if topic is not None]

    def scan(self) -> Iterator[Chunk | Metadata]:
        """Yield all chunks and records of metadata in the order of the file."""
        if self.size == 0:
            self.report(0, 0, "it is empty")
            return
        limit = self.index.place if self.index else self.size
        place, ended = min(len(MAGIC), self.size), False
        if self._read(0, len(MAGIC)) != MAGIC:
            self.report(0, place, "it does not begin as MCAP does")
        while place < limit and not ended:
            found = self._record(place, limit)
            if isinstance(found, str):
                resumed = self._resumed(place, limit)
                self.report(place, resumed, found)
                place = resumed
            else:
                opcode, place, content = found
                ended = opcode == Opcode.DATA_END
                if content is not None:
                    yield content
        if self.index is None:
            self.report(place, self.size, "the index at the end is damaged" if ended else "it was not closed")

    def spans(self) -> Iterator[Span]:
        """Yield all chunks with messages that the index lists, in the order of the file; none without an index."""
        numbered = {number: channel.topic for number, channel in self._channels.items()}
        everything = frozenset(numbered.values())
        for chunk in sorted(self.index.chunks if self.index else (), key=lambda chunk: chunk.chunk_start_offset):
            topics = frozenset(numbered[number] for number in chunk.message_index_offsets if number in numbered)
            if topics or chunk.message_end_time:
                times = chunk.message_start_time, chunk.message_end_time
                yield Span(chunk.chunk_start_offset, *times, topics or everything)

    def chunks_at(self, places: Iterable[int]) -> Iterator[Chunk]:
        """Yield the chunks at places that the index lists."""
        for place in places:
            chunk = self._chunk(place, self.size)
            if isinstance(chunk, Chunk):
                yield chunk
            else:
                self.report(place, place, chunk)

    def messages(self, chunk: Chunk) -> Iterator[StoredMessage]:
        """Yield the messages of a chunk; messages of topics that were defined in a lost chunk are damage."""
        unknown = 0
        for opcode, content in _records(chunk.data):
            if opcode == Opcode.MESSAGE:
                number, sequence, log_time, publish_time = MESSAGE.unpack_from(content)
                topic = self._topics.get(number) or self._topic(number)
                if topic is None:
                    unknown += 1
                else:
                    yield StoredMessage(topic, sequence, log_time, publish_time, content[MESSAGE.size :])
            elif _register(opcode, content, self._schemas, self._channels):
                self._topics.clear()
        if unknown:
            self.report(chunk.place, chunk.end, f"{unknown} messages are of topics whose names are lost")

    def report(self, place: int, end: int, reason: str) -> None:
        """Report damage from byte ``place`` to before ``end``."""
        self._damaged(Damage(self.name, place, end, reason))

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
        if opcode == Opcode.MESSAGE:
            return "messages outside of chunks have no checksum"
        if opcode not in OUTSIDE or length > LARGEST:
            return "no record begins there"
        if end > limit:
            return "the file ends within a record"
        if opcode == Opcode.MESSAGE_INDEX:
            _, size = ENTRIES.unpack(self._read(place + RECORD, ENTRIES.size).ljust(ENTRIES.size))
            return (opcode, end, None) if length == ENTRIES.size + size else "a record is damaged"
        record = _parsed(OUTSIDE[opcode], self._read(place, RECORD + length))
        if record is None:
            return "a record is damaged"
        return opcode, end, record if isinstance(record, Metadata) else None

    def _chunk(self, place: int, limit: int) -> Chunk | str:
        """The chunk at a place, or what is wrong with it."""
        head = self._read(place, CHUNK.size + 12)
        if len(head) < CHUNK.size + 12:
            return "the file ends within a chunk"
        opcode, length, _, _, size, crc, named = CHUNK.unpack_from(head)
        packed = int.from_bytes(head[CHUNK.size + named :][:8], "little")
        end = place + RECORD + length
        if (
            opcode != Opcode.CHUNK
            or head[CHUNK.size :][:named] not in COMPRESSIONS
            or place + CHUNK.size + named + 8 + packed != end
        ):
            return "the beginning of a chunk is damaged"
        if end > limit:
            return "the file ends within a chunk"
        if max(packed, size) > LARGEST:
            return f"a chunk has more than {LARGEST} bytes"
        if crc == 0 and self.index is None:
            return "a chunk has no checksum that would show that it is whole"
        try:
            record = McapChunk.read(_stream_of(self._read(place + RECORD, length)))
            stream, size = get_chunk_data_stream(record, validate_crc=True)
            return Chunk(place, end, stream.read(size))
        except UNREADABLE as reason:
            return f"a chunk is damaged ({' '.join(str(reason).split())})"

    def _resumed(self, place: int, limit: int) -> int:
        """Where reading goes on behind a damaged record: at its end if a whole one follows, else at the next chunk."""
        if place + RECORD <= limit:
            _, length = START.unpack(self._read(place, RECORD))
            end = place + RECORD + int(length)
            if end < limit and not isinstance(self._record(end, limit), str):
                return end
        return self._next_chunk(place + 1, limit)

    def _next_chunk(self, place: int, limit: int) -> int:
        """Where the next whole chunk begins; ``limit`` if there is none."""
        while place < limit:
            window = self._read(place, min(WINDOW + CHUNK.size + 12, limit - place))
            for found in CHUNK_START.finditer(window):
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
        if not len(MAGIC) <= start <= before:
            return None
        summary = self._read(start, before + FOOTER.size - len(MAGIC) - 4 - start)
        if crc not in (0, zlib.crc32(summary)):
            return None
        index = Index(start)
        try:
            for opcode, content in _records(summary[: before - start]):
                _register(opcode, content, index.schemas, index.channels)
                if opcode == Opcode.CHUNK_INDEX:
                    index.chunks.append(ChunkIndex.read(_stream_of(content)))
        except UNREADABLE:
            return None
        return index


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
    """Note the definition of a type or a topic; whether the record is one."""
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(_stream_of(content))
        schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = Channel.read(_stream_of(content))
        channels[channel.id] = channel
    return opcode in (Opcode.SCHEMA, Opcode.CHANNEL)


def _parsed(kind: Any, data: bytes) -> McapRecord | None:
    """A record whose lengths are right: writing it again gives the same bytes."""
    try:
        record: McapRecord = kind.read(_stream_of(data[RECORD:]))
        builder: Any = RecordBuilder()
        record.write(builder)
    except UNREADABLE:
        return None
    return record if bytes(builder.end()) == data else None
