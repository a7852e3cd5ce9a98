"""The file format, judged by the MCAP library: by its reader, and by what its own writer writes."""

import io
import zlib

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import (
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MessageIndex,
    MetadataIndex,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from wheelset_track_sim.bags.mcap.writer import MAGIC, McapWriter

CHUNKS = [[(1, 50), (2, 40)], [(1, 60), (2, 60), (1, 55)], [(2, 90)]]
"""Channel and time of the messages of three chunks; times need not rise."""


def payload(chunk: int, number: int) -> bytes:
    return np.random.default_rng([chunk, number]).bytes(100 + 7 * number) + bytes(300)


def ours() -> bytes:
    stream = io.BytesIO()
    file = McapWriter(stream, "ros2", "test")
    file.add_metadata("about", {"é": "ü", "b": "2"})
    for name in ("one", "two"):
        file.add_channel(f"/{name}", "cdr", file.add_schema(f"p/msg/{name}", "ros2msg", b"float64 x"), {"k": name})
    for chunk, messages in enumerate(CHUNKS):
        for number, (channel, time) in enumerate(messages):
            file.add_message(channel, time, number, memoryview(payload(chunk, number)))
        file.flush()
    file.flush()
    file.finish()
    return stream.getvalue()


def theirs() -> bytes:
    stream = io.BytesIO()
    file = Writer(stream, enable_data_crcs=True)
    file.start("ros2", "test")
    file.add_metadata("about", {"é": "ü", "b": "2"})
    for name in ("one", "two"):
        file.register_channel(
            f"/{name}", "cdr", file.register_schema(f"p/msg/{name}", "ros2msg", b"float64 x"), {"k": name}
        )
    for chunk, messages in enumerate(CHUNKS):
        for number, (channel, time) in enumerate(messages):
            file.add_message(channel, time, payload(chunk, number), time, number)
        file.flush()
    file.finish()
    return stream.getvalue()


def records_of(data: bytes) -> list[McapRecord]:
    """All records but those whose numbers follow from how well the chunks compress."""
    differing = (DataEnd, Footer, ChunkIndex, MetadataIndex, SummaryOffset)
    records = StreamReader(io.BytesIO(data), validate_crcs=True).records
    return [record for record in records if not isinstance(record, differing)]


def test_the_records_are_those_of_the_librarys_writer() -> None:
    assert records_of(ours()) == records_of(theirs())


def test_chunks_hold_the_same_bytes() -> None:
    found, expected = (
        [
            (chunk.compression, chunk.uncompressed_size, chunk.uncompressed_crc, chunk.message_start_time)
            for chunk in StreamReader(io.BytesIO(data), emit_chunks=True).records
            if isinstance(chunk, Chunk)
        ]
        for data in (ours(), theirs())
    )
    assert len(found) == 3
    assert found == expected


@pytest.mark.parametrize("topics", [["/one"], ["/two"], ["/two", "/one"]])
@pytest.mark.parametrize("backwards", [False, True])
def test_indexes_lead_to_the_messages(topics: list[str], backwards: bool) -> None:
    reader = make_reader(io.BytesIO(ours()), validate_crcs=True)
    found = [(message.log_time, message.data) for *_, message in reader.iter_messages(topics, reverse=backwards)]
    expected = [
        (time, payload(chunk, number))
        for chunk, messages in enumerate(CHUNKS)
        for number, (channel, time) in enumerate(messages)
        if ("/one", "/two")[channel - 1] in topics
    ]
    assert [time for time, _ in found] == sorted((time for time, _ in expected), reverse=backwards)
    assert sorted(found) == sorted(expected)
    assert [record.metadata for record in reader.iter_metadata()] == [{"é": "ü", "b": "2"}]


def test_every_place_in_the_indexes_is_right() -> None:
    data = ours()
    summary = make_reader(io.BytesIO(data)).get_summary()
    assert summary is not None
    for index in summary.chunk_indexes:
        chunk = next(StreamReader(io.BytesIO(data[index.chunk_start_offset :]), True, emit_chunks=True).records)
        assert isinstance(chunk, Chunk)
        assert len(chunk.data) == index.compressed_size
        after = index.chunk_start_offset + index.chunk_length
        assert min(index.message_index_offsets.values()) == after
        for channel, place in index.message_index_offsets.items():
            entries = next(StreamReader(io.BytesIO(data[place:]), True).records)
            assert isinstance(entries, MessageIndex)
            assert entries.channel_id == channel


def test_groups_of_the_summary_are_where_it_says() -> None:
    data = ours()
    groups = [record for record in StreamReader(io.BytesIO(data)).records if isinstance(record, SummaryOffset)]
    assert len(groups) == 5
    for group in groups:
        end = group.group_start + group.group_length
        assert data[group.group_start] == group.group_opcode
        assert data[end] in {other.group_opcode for other in groups} | {Opcode.SUMMARY_OFFSET}


def test_checksums_cover_all_bytes() -> None:
    data = ours()
    records = list(StreamReader(io.BytesIO(data)).records)
    footer = records[-1]
    assert isinstance(footer, Footer)
    data_end = next(record for record in records if isinstance(record, DataEnd))
    end_record = 9 + 4
    assert data_end.data_section_crc == zlib.crc32(data[: footer.summary_start - end_record])
    assert footer.summary_crc == zlib.crc32(data[footer.summary_start : -len(MAGIC) - 4])


def test_without_messages_it_is_a_file_nevertheless() -> None:
    stream = io.BytesIO()
    McapWriter(stream, "ros2", "test").finish()
    reader = make_reader(io.BytesIO(stream.getvalue()), validate_crcs=True)
    assert list(reader.iter_messages()) == []
