"""MCAP files record by record: changed, and put together again with sizes and checksums that are right."""

import struct
import zlib
from typing import NamedTuple

import lz4.frame
from hypothesis import strategies as st
from mcap.opcode import Opcode
from zstandard import ZstdCompressor, ZstdDecompressor

from support.mutants import mutated_bytes

MAGIC = b"\x89MCAP0\r\n"
UNPACK = {b"": bytes, b"zstd": lambda data: ZstdDecompressor().decompress(data), b"lz4": lz4.frame.decompress}
PACK = {b"": bytes, b"zstd": lambda data: ZstdCompressor().compress(data), b"lz4": lz4.frame.compress}
SIZES = st.sampled_from([0, 1, 100, 1 << 28, 1 << 31, 1 << 40, (1 << 63) - 1, (1 << 64) - 1])


class Record(NamedTuple):
    """A record of a file."""

    opcode: int
    content: bytes
    declared: int | None = None
    """Length that it has by its head, if that is another one."""

    @property
    def packed(self) -> bytes:
        return struct.pack("<BQ", self.opcode, len(self.content) if self.declared is None else self.declared) + (
            self.content
        )


def records_of(data: bytes) -> list[Record]:
    """Records in a stretch of whole ones."""
    found, place = [], 0
    while place < len(data):
        opcode, length = struct.unpack_from("<BQ", data, place)
        found.append(Record(opcode, data[place + 9 : place + 9 + length]))
        place += 9 + length
    return found


@st.composite
def changed_records(draw: st.DrawFn, data: bytes) -> bytes:
    """A whole file with one to three of its records, or of those in its chunks, changed; checksums are right."""
    records = records_of(data[len(MAGIC) : -len(MAGIC)])
    for _ in range(draw(st.integers(1, 3))):
        number = draw(st.integers(0, len(records) - 1)) if records else 0
        if records and records[number].opcode == Opcode.CHUNK and draw(st.booleans()):
            records[number] = draw(_changed_chunk(records[number]))
        else:
            records = draw(_changed_list(records))
    return _assembled(records)


@st.composite
def _changed_list(draw: st.DrawFn, records: list[Record]) -> list[Record]:
    """Records, one of which is changed, removed, doubled, moved, or of another length or kind."""
    found = [*records]
    if not found:
        return found
    number = draw(st.integers(0, len(found) - 1))
    record = found[number]
    how = draw(st.sampled_from(["content", "content", "number", "remove", "double", "move", "length", "kind"]))
    if how == "content":
        found[number] = record._replace(content=draw(mutated_bytes(record.content)))
    elif how == "number" and len(record.content) >= 8:
        place = draw(st.integers(0, len(record.content) - 8))
        value = struct.pack("<Q", draw(SIZES))[: draw(st.sampled_from([2, 4, 8]))]
        found[number] = record._replace(content=record.content[:place] + value + record.content[place + len(value) :])
    elif how == "remove":
        del found[number]
    elif how == "double":
        found[number:number] = [record] * draw(st.sampled_from([1, 2, 50]))
    elif how == "move":
        found.insert(draw(st.integers(0, len(found) - 1)), found.pop(number))
    elif how == "length":
        found[number] = record._replace(declared=draw(SIZES))
    else:
        found[number] = record._replace(opcode=draw(st.integers(0, 20)))
    return found


@st.composite
def _changed_chunk(draw: st.DrawFn, chunk: Record) -> Record:
    """A chunk with other records in it, or another compression, size or checksum."""
    times, (size, crc, named) = chunk.content[:16], struct.unpack_from("<QII", chunk.content, 16)
    compression = chunk.content[32 : 32 + named]
    data = UNPACK[compression](chunk.content[32 + named + 8 :])
    data = b"".join(record.packed for record in draw(_changed_list(records_of(data))))
    how = draw(st.sampled_from(["right", "right", "right", "size", "crc", "time", "frames"]))
    compression = draw(st.sampled_from([*PACK]))
    packed = PACK[compression](data) * (2 if how == "frames" else 1)
    size, crc = len(data), zlib.crc32(data)
    size = draw(SIZES) if how == "size" else size
    crc = 0 if how == "crc" else crc
    times = struct.pack("<QQ", draw(SIZES), draw(SIZES)) if how == "time" else times
    head = times + struct.pack("<QII", size, crc, len(compression)) + compression
    return Record(Opcode.CHUNK, head + struct.pack("<Q", len(packed)) + packed)


def _assembled(records: list[Record]) -> bytes:
    """A file of records; its end leads to the summary and has the right checksum, if there still is one."""
    out, summary = bytearray(MAGIC), 0
    for record in records:
        if record.opcode == Opcode.FOOTER and len(record.content) == 20:
            offsets = struct.unpack_from("<Q", record.content, 8)[0]
            content = struct.pack("<QQ", summary, min(offsets, len(out)))
            content += struct.pack("<I", zlib.crc32(out[summary:] + record.packed[:9] + content))
            out += record._replace(content=content).packed
            continue
        out += record.packed
        if record.opcode == Opcode.DATA_END:
            summary = len(out)
    return bytes(out) + MAGIC
