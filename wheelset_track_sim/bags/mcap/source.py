"""An MCAP file while it is read, and nothing in it believed that no checksum covers.

The library's readers stop at the first byte that is not what it should be, and do not check what an index says. Here a
file is gone through from its beginning. Chunks are yielded whole and with the right CRC; between them, what cannot be
read is skipped to the next place where such a chunk begins, and is told. https://mcap.dev/spec
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, BinaryIO

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, ChunkIndex, DataEnd, Header, Metadata, Schema
from mcap.records import Chunk as McapChunk
from mcap.stream_reader import get_chunk_data_stream

from ..losses import Damage
from .records import START, UNREADABLE, Chunk, Message, parsed, records, register, stream_of
from .writer import MAGIC, RECORD

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
"""Records that stand between chunks."""
COMPRESSIONS = (b"", b"lz4", b"zstd")
WINDOW = 1 << 20
"""Bytes that are searched at a time."""
LARGEST = 1 << 30
"""Largest record that is read, bytes."""


@dataclass
class Index:
    """What stands at the end of a file that was closed."""

    place: int
    """First byte after the chunks."""
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)


class McapSource:
    """Reads a stream that it does not close; OSError is all that is raised for what the file holds."""

    def __init__(self, stream: BinaryIO, name: str) -> None:
        """Look at the end of the file in ``stream``; ``name`` is what losses call it."""
        self.name = name
        self._stream = stream
        self.size = stream.seek(0, 2)
        self.index = self._read_index()
        """None if the file was not closed or its end is damaged."""
        self.schemas: dict[int, Schema] = dict(self.index.schemas) if self.index else {}
        self.channels: dict[int, Channel] = dict(self.index.channels) if self.index else {}
        """By number; those of a file without an index are known when their chunks have been read."""

    def scan(self) -> Iterator[Chunk | Metadata | Damage]:
        """All that the file holds, in its order."""
        if self.size == 0:
            yield Damage(self.name, 0, 0, "it is empty")
            return
        limit = self.index.place if self.index else self.size
        place, ended = min(len(MAGIC), self.size), False
        if self._read(0, len(MAGIC)) != MAGIC:
            yield Damage(self.name, 0, place, "it does not begin as MCAP does")
        while place < limit and not ended:
            found = self._record(place, limit)
            if isinstance(found, str):
                resumed = self._resumed(place, limit)
                yield Damage(self.name, place, resumed, found)
                place = resumed
            else:
                opcode, place, content = found
                ended = opcode == Opcode.DATA_END
                if content is not None:
                    yield content
        if self.index is None:
            yield Damage(
                self.name, place, self.size, "the index at the end is damaged" if ended else "it was not closed"
            )

    def chunks_at(self, places: Iterable[int]) -> Iterator[Chunk | Damage]:
        """Chunks at places that the index names."""
        for place in places:
            chunk = self._chunk(place, self.size)
            yield chunk if isinstance(chunk, Chunk) else Damage(self.name, place, place, chunk)

    def topics(self) -> list[tuple[Channel, Schema]]:
        """Topics that are known, in the order of their numbers, with their types."""
        return [
            (channel, self.schemas[channel.schema_id])
            for _, channel in sorted(self.channels.items())
            if channel.schema_id in self.schemas
        ]

    def messages(self, chunk: Chunk) -> list[Message | Damage]:
        """Messages of a chunk; those of topics that were defined in a chunk that is lost are so, too."""
        found: list[Message | Damage] = []
        unknown = 0
        for opcode, content in records(chunk.data):
            if opcode == Opcode.MESSAGE:
                number, sequence, log_time, publish_time = MESSAGE.unpack_from(content)
                channel = self.channels.get(number)
                schema = self.schemas.get(channel.schema_id) if channel else None
                if channel is None or schema is None:
                    unknown += 1
                else:
                    data = content[MESSAGE.size :]
                    found.append(Message(schema, channel, sequence, log_time, publish_time, data))
            else:
                register(opcode, content, self.schemas, self.channels)
        if unknown:
            reason = f"{unknown} messages are of topics whose names are lost"
            found.append(Damage(self.name, chunk.place, chunk.end, reason))
        return found

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
        record = parsed(OUTSIDE[opcode], self._read(place, RECORD + length))
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
            record = McapChunk.read(stream_of(self._read(place + RECORD, length)))
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
            for opcode, content in records(summary[: before - start]):
                register(opcode, content, index.schemas, index.channels)
                if opcode == Opcode.CHUNK_INDEX:
                    index.chunks.append(ChunkIndex.read(stream_of(content)))
        except UNREADABLE:
            return None
        return index
