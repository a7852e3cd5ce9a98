"""A file cannot ask for more work or memory than one of its size may need."""

import struct
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode
from zstandard import ZstdCompressor

from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.mcap.reader import MOST_DAMAGES, Chunk, McapReader
from wheelset_track_sim.bags.mcap.unpacking import LARGEST, unpacked
from wheelset_track_sim.bags.mcap.writer import MAGIC
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.errors import RecordingError

PACKERS: dict[bytes, Callable[[bytes], bytes]] = {
    b"": lambda data: data,
    b"zstd": lambda data: ZstdCompressor().compress(data),
    b"lz4": lambda data: bytes(lz4.frame.compress(data)),
}
PACKED = [name for name in PACKERS if name]
LENGTH = 20


@given(st.sampled_from([*PACKERS]), st.lists(st.binary(min_size=1), min_size=1, max_size=3), st.integers(-3, 3))
def test_chunks_hold_what_they_declare_or_are_refused(name: bytes, frames: list[bytes], off: int) -> None:
    packed, data = b"".join(map(PACKERS[name], frames)), b"".join(frames)
    size = max(0, len(data) + off)
    if size == len(data):
        assert unpacked(name, packed, size) == data
    else:
        with pytest.raises(ValueError, match=f"it declares {size} bytes and unpacks to"):
            unpacked(name, packed, size)


def chunk(data: bytes, compression: bytes, declared: int, packed: bytes | None = None) -> bytes:
    """A chunk's record, with the CRC of ``data``."""
    packed = PACKERS[compression](data) if packed is None else packed
    content = struct.pack("<QQQI", 0, 1, declared, zlib.crc32(data))
    content += struct.pack("<I", len(compression)) + compression + struct.pack("<Q", len(packed)) + packed
    return struct.pack("<BQ", Opcode.CHUNK, len(content)) + content


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, make_small_run: Callable[..., object]) -> tuple[bytes, int]:
    """A bag as bytes, and where its first chunk begins."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    make_small_run(path, chunks=4, length=LENGTH)
    with path.open("rb") as stream:
        layout = McapReader(stream, path.name, pytest.fail).layout
    assert layout is not None
    return path.read_bytes(), layout.parts[0].place


def with_records(tmp_path: Path, whole: tuple[bytes, int], records: bytes) -> Path:
    """The bag with further records before its first chunk, so that its index leads nowhere."""
    data, place = whole
    path = tmp_path / "run.mcap"
    path.write_bytes(data[:place] + records + data[place:])
    return path


def assert_all_else_is_read(path: Path, reason: str) -> None:
    losses: list[object] = []
    begun = time.process_time()
    assert len(read_bag(path, lost=losses.append)) == 4 * LENGTH
    assert time.process_time() - begun < 60
    assert any(reason in str(loss) for loss in losses), losses
    assert not overview(path).complete
    recover(path, path.with_name("saved"))
    assert overview(path.with_name("saved")).complete
    with pytest.raises(RecordingError, match="is not a complete bag"):
        read_bag(path)


@pytest.mark.parametrize("compression", PACKED)
def test_a_chunk_that_unpacks_to_far_more_than_it_declares(
    tmp_path: Path, whole: tuple[bytes, int], compression: bytes
) -> None:
    bomb = PACKERS[compression](bytes(1 << 26))
    record = chunk(bytes(1000), compression, 1000, bomb)
    assert_all_else_is_read(with_records(tmp_path, whole, record), "it declares 1000 bytes and unpacks to more")


def test_frames_after_frames(tmp_path: Path, whole: tuple[bytes, int]) -> None:
    bomb = PACKERS[b"lz4"](bytes(1 << 22)) * 200
    record = chunk(bytes(100), b"lz4", 100, bomb)
    assert_all_else_is_read(with_records(tmp_path, whole, record), "it declares 100 bytes and unpacks to more")


def test_a_chunk_that_declares_more_than_is_read(tmp_path: Path, whole: tuple[bytes, int]) -> None:
    record = chunk(b"", b"zstd", LARGEST + 1, b"")
    assert_all_else_is_read(with_records(tmp_path, whole, record), f"a chunk has more than {LARGEST} bytes")


@pytest.mark.parametrize(
    ("record", "reason"),
    [
        (struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6, 1, 0), "more than 100000 records hold no samples"),
        (chunk(b"", b"", 0), "a chunk has no checksum"),
        (chunk(b"x", b"", 2), "a chunk is damaged"),
    ],
    ids=["indexes", "chunks", "wrong chunks"],
)
def test_records_that_hold_nothing(tmp_path: Path, whole: tuple[bytes, int], record: bytes, reason: str) -> None:
    assert_all_else_is_read(with_records(tmp_path, whole, record * 120_000), reason)


@pytest.mark.parametrize(("size", "count"), [(1 << 21, 1), (1 << 19, 140)])
def test_definitions_that_fill_memory(tmp_path: Path, whole: tuple[bytes, int], size: int, count: int) -> None:
    def schema(number: int) -> bytes:
        parts = (b"x/msg/Y", b"ros2msg", bytes(size))
        content = struct.pack("<H", number) + b"".join(struct.pack("<I", len(part)) + part for part in parts)
        data = struct.pack("<BQ", Opcode.SCHEMA, len(content)) + content
        return chunk(data, b"zstd", len(data))

    path = with_records(tmp_path, whole, b"".join(schema(1000 + number) for number in range(count)))
    assert_all_else_is_read(path, "a definition is too large, or the definitions of the file are")


@pytest.mark.slow
def test_more_messages_than_a_file_of_its_size_can_hold(tmp_path: Path, whole: tuple[bytes, int]) -> None:
    message = struct.pack("<BQHIQQ", Opcode.MESSAGE, 22, 1, 0, 0, 0)
    record = chunk(message * 1_500_000, b"zstd", len(message) * 1_500_000)
    path = with_records(tmp_path, whole, record)
    losses: list[object] = []
    with pytest.raises(RecordingError, match="holds no complete chunk"):
        read_bag(path, lost=losses.append)
    assert any("the file holds more records than one of its size can" in str(loss) for loss in losses)


def test_the_bytes_that_a_file_unpacks_to_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(MAGIC + chunk(bytes(1 << 20), b"zstd", 1 << 20) * 40)
    monkeypatch.setattr("wheelset_track_sim.bags.mcap.reader.MOST_BYTES", 1 << 23)
    monkeypatch.setattr("wheelset_track_sim.bags.mcap.reader.BYTES_PER_BYTE", 1)
    losses: list[object] = []
    with path.open("rb") as stream:
        found = [part for part in McapReader(stream, path.name, losses.append).scan() if isinstance(part, Chunk)]
    assert len(found) <= 8
    assert any("unpacks to more bytes than one of its size can" in str(loss) for loss in losses)


def test_damage_is_listed_up_to_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = chunk(b"x", b"", 1)
    path.write_bytes(MAGIC + (b"\0" + whole) * 1500)
    losses: list[object] = []
    with path.open("rb") as stream:
        assert sum(1 for _ in McapReader(stream, path.name, losses.append).scan()) >= 1000
    assert len(losses) == MOST_DAMAGES
    assert str(losses[-1]).endswith("further damage is not listed")


@pytest.mark.parametrize("size", [0, 5, 17, 2**63])
def test_an_index_of_wrong_sizes(tmp_path: Path, whole: tuple[bytes, int], size: int) -> None:
    """Its checksum is right, and its entries lead out of it."""
    data, _ = whole
    start = struct.unpack_from("<Q", data, len(data) - 8 - 4 - 16)[0]
    summary = bytearray(data[start : len(data) - 8 - 4])
    place = 0
    while summary[place] != Opcode.CHUNK_INDEX:
        place += 9 + struct.unpack_from("<Q", summary, place + 1)[0]
    struct.pack_into("<Q", summary, place + 1, size)
    path = tmp_path / "run.mcap"
    path.write_bytes(data[:start] + summary + struct.pack("<I", zlib.crc32(summary)) + MAGIC)
    losses: list[object] = []
    assert len(read_bag(path, lost=losses.append)) == 4 * LENGTH
