"""Records of MCAP files that are read without trust."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Any, NamedTuple

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Schema
from zstandard import ZstdError

from .writer import RECORD

START = struct.Struct("<BQ")  # opcode, length
UNREADABLE = (McapError, ZstdError, struct.error, ValueError, LookupError, RuntimeError, MemoryError, OverflowError)
"""What the libraries raise for bytes that are not what they should be."""


@dataclass(frozen=True)
class Chunk:
    """A chunk whose bytes are those that were written."""

    place: int
    """First byte in the file."""
    end: int
    """First byte after it."""
    data: bytes
    """Its records, decompressed."""


class Message(NamedTuple):
    """A message as it is stored."""

    schema: Schema
    channel: Channel
    sequence: int
    log_time: int
    """ns"""
    publish_time: int
    """ns"""
    data: memoryview


def records(data: bytes) -> Iterator[tuple[int, memoryview]]:
    """Opcode and content of records, as far as they are whole."""
    view, place = memoryview(data), 0
    while place + RECORD <= len(view):
        opcode, length = START.unpack_from(view, place)
        place += RECORD + length
        if place > len(view):
            return
        yield opcode, view[place - length : place]


def stream_of(content: bytes | memoryview) -> ReadDataStream:
    """A record's content as the library reads it."""
    return ReadDataStream(BytesIO(content))


def register(opcode: int, content: memoryview, schemas: dict[int, Schema], channels: dict[int, Channel]) -> None:
    """Note the definition of a type or a topic."""
    if opcode == Opcode.SCHEMA:
        schema = Schema.read(stream_of(content))
        schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = Channel.read(stream_of(content))
        channels[channel.id] = channel


def parsed(kind: Any, data: bytes) -> McapRecord | None:
    """A record whose lengths are all right: written again, it gives the same bytes."""
    try:
        record: McapRecord = kind.read(stream_of(data[RECORD:]))
        builder: Any = RecordBuilder()
        record.write(builder)
    except UNREADABLE:
        return None
    return record if bytes(builder.end()) == data else None
