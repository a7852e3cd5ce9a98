"""Bags as other programs write them: the same messages in files of many kinds."""

import random
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Metadata
from mcap.writer import CompressionType, IndexType, Writer

INDEXES = (IndexType.NONE, IndexType.CHUNK, IndexType.MESSAGE, IndexType.CHUNK | IndexType.METADATA, IndexType.ALL)
ORDERS = ("time", "topic", "topics reversed", "shuffled")


class Entry(NamedTuple):
    """A message of a bag, with what its topic and type are."""

    topic: str
    type: str
    definition: bytes
    metadata: Mapping[str, str]
    time_ns: int
    data: bytes


@dataclass(frozen=True)
class Kind:
    """How a file is written."""

    chunk_size: int = 1 << 20
    chunked: bool = True
    compression: CompressionType = CompressionType.ZSTD
    index: IndexType = IndexType.ALL
    channels: bool = True
    schemas: bool = True
    statistics: bool = True
    offsets: bool = True
    crcs: bool = True
    data_crc: bool = False
    order: str = "time"
    pace: int = 1
    """Time between messages of the file, over that in the run: topics that are stored apart may be far apart."""

    def paced(self, entries: Sequence[Entry]) -> list[Entry]:
        """Entries at their times in the file."""
        start = entries[0].time_ns if entries else 0
        return [entry._replace(time_ns=start + self.pace * (entry.time_ns - start)) for entry in entries]

    def arranged(self, entries: Iterable[Entry]) -> list[Entry]:
        """Entries at their times, in the order of the file."""
        found = self.paced([*entries])
        if self.order == "shuffled":
            random.Random(1).shuffle(found)
        elif self.order != "time":
            topics = sorted({entry.topic for entry in found}, reverse=self.order == "topics reversed")
            found.sort(key=lambda entry: topics.index(entry.topic))
        return found


KINDS = st.builds(
    Kind,
    chunk_size=st.sampled_from([1, 2_000, 30_000, 1 << 20]),
    chunked=st.booleans(),
    compression=st.sampled_from(CompressionType),
    index=st.sampled_from(INDEXES),
    channels=st.booleans(),
    schemas=st.booleans(),
    statistics=st.booleans(),
    offsets=st.booleans(),
    crcs=st.booleans(),
    data_crc=st.booleans(),
    order=st.sampled_from(ORDERS),
    pace=st.sampled_from([1, 100_000]),
)


def entries_of(path: Path) -> tuple[list[Entry], list[Metadata]]:
    """All messages of a file in the order of time, and its records of metadata."""
    with path.open("rb") as stream:
        reader = make_reader(stream)
        found = [
            Entry(channel.topic, schema.name, schema.data, channel.metadata, message.log_time, message.data)
            for schema, channel, message in reader.iter_messages()
            if schema is not None
        ]
        return found, [*reader.iter_metadata()]


def write(path: Path, entries: Iterable[Entry], records: Iterable[Metadata] = (), kind: Kind | None = None) -> Path:
    """Write a file of messages with the MCAP library."""
    kind = kind or Kind()
    with path.open("wb") as stream:
        writer = Writer(
            stream,
            chunk_size=kind.chunk_size,
            use_chunking=kind.chunked,
            compression=kind.compression,
            index_types=kind.index,
            repeat_channels=kind.channels,
            repeat_schemas=kind.schemas,
            use_statistics=kind.statistics,
            use_summary_offsets=kind.offsets,
            enable_crcs=kind.crcs,
            enable_data_crcs=kind.data_crc,
        )
        writer.start("ros2", "another writer")
        for record in records:
            writer.add_metadata(record.name, record.metadata)
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for number, entry in enumerate(kind.arranged(entries)):
            if entry.type not in schemas:
                schemas[entry.type] = writer.register_schema(entry.type, "ros2msg", entry.definition)
            if entry.topic not in channels:
                of = schemas[entry.type]
                channels[entry.topic] = writer.register_channel(entry.topic, "cdr", of, dict(entry.metadata))
            writer.add_message(channels[entry.topic], entry.time_ns, entry.data, entry.time_ns, number)
        writer.finish()
    return path


def changed(entry: Entry, change: Callable[[Any], object]) -> Entry:
    """The entry with another content: ``change`` sets fields of its message."""
    from wheelset_track_sim.bags.definitions import deserialise, short_name, typestore

    message = deserialise(short_name(entry.type), entry.data)
    change(message)
    return entry._replace(data=bytes(typestore().serialize_cdr(message, entry.type)))
