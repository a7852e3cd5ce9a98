"""Whatever kind of file a writer makes of a run, it is read, listed, played and recovered whole."""

import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.opcode import Opcode
from mcap.writer import CompressionType

from support.rewriting import KINDS, Kind, entries_of, write
from wheelset_track_sim.bags import Recording, read_bag
from wheelset_track_sim.bags.mcap.writer import MAGIC
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.errors import RecordingError

CHUNKS, LENGTH = 8, 20
STEPS = CHUNKS * LENGTH


class Source:
    """A run: its messages, and what is read of it."""

    def __init__(self, path: Path) -> None:
        self.entries, self.records = entries_of(path)
        self.run = read_bag(path)

    def __repr__(self) -> str:
        return "Source"


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory, make_small_run: Callable[..., object]) -> Source:
    path = tmp_path_factory.mktemp("source") / "run.mcap"
    make_small_run(path, chunks=CHUNKS, length=LENGTH)
    return Source(path)


def assert_part(found: Recording, whole: Recording, part: slice) -> None:
    for name in ("steps", "time", "position", "speed", "revision", "forces"):
        assert getattr(found, name).tobytes() == getattr(whole, name)[part].tobytes(), name
    nodes = [found.nodes.index(node) for node in whole.nodes]  # in the order in which the writer met them
    assert found.stresses[:, nodes].tobytes() == whole.stresses[part].tobytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kinds")


@given(kind=KINDS, first=st.integers(0, STEPS - 1), count=st.integers(1, STEPS))
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_kind_of_file_holds_the_run(folder: Path, source: Source, kind: Kind, first: int, count: int) -> None:
    entries, records, whole = source.entries, source.records, source.run
    path = write(folder / "run.mcap", entries, records, kind)
    assert_part(read_bag(path), whole, slice(None))
    assert_part(read_bag(path, steps=(first, first + count)), whole, slice(first, first + count))
    losses: list[object] = []
    assert_part(read_bag(path, lost=losses.append), whole, slice(None))
    assert losses == []
    found = overview(path)
    assert found.complete, found.losses
    assert (found.steps, found.info.scenario_name) == (STEPS, "undamaged")
    with RecordedBag(path) as bag:
        played = [item[:3] for item in bag.messages(0, 2**62, {*bag.topics})]
        assert bag.damages == []
    assert sorted(played) == sorted((entry.time_ns, entry.topic, entry.data) for entry in kind.paced(entries))
    assert [time for time, *_ in played] == sorted(time for time, *_ in played)
    saved = recover(path, folder / "saved.mcap")
    assert (saved.steps, saved.messages, saved.losses, saved.chunks_lost) == (STEPS, len(entries), (), 0)
    assert_part(read_bag(saved.path), whole, slice(None))
    saved.path.unlink()


@pytest.mark.parametrize("chunked", [True, False])
def test_messages_that_were_compressed_one_by_one_are_unpacked(tmp_path: Path, source: Source, chunked: bool) -> None:
    """As rosbag2 does with ``--compression-mode message``."""
    packed = [entry._replace(data=zstandard.compress(entry.data)) for entry in source.entries]
    kind = Kind(chunked=chunked, compression=CompressionType.NONE)
    path = write(tmp_path / "run.mcap", packed, source.records, kind)
    assert_part(read_bag(path), source.run, slice(None))
    assert overview(path).complete
    with RecordedBag(path) as bag:
        played = [item[:3] for item in bag.messages(0, 2**62, {*bag.topics})]
    assert sorted(played) == sorted((entry.time_ns, entry.topic, entry.data) for entry in source.entries)
    saved = recover(path, tmp_path / "saved.mcap")
    assert {entry.data for entry in entries_of(saved.path)[0]} == {entry.data for entry in source.entries}


def test_a_message_that_unpacks_to_too_much_is_damage(tmp_path: Path, source: Source) -> None:
    bomb = source.entries[1]._replace(data=zstandard.compress(bytes(3 << 28)))
    path = write(tmp_path / "run.mcap", [source.entries[0], bomb, *source.entries[2:]], source.records)
    losses: list[object] = []
    assert len(read_bag(path, lost=losses.append)) == STEPS - LENGTH
    assert losses


def test_a_flipped_bit_outside_of_chunks_is_seen_where_there_is_a_checksum(tmp_path: Path, source: Source) -> None:
    path = write(tmp_path / "run.mcap", source.entries, source.records, Kind(chunked=False, data_crc=True))
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    with pytest.raises(RecordingError, match="the checksum of the file is wrong"):
        read_bag(path)
    with pytest.raises(RecordingError, match="holds no message that can be read"):
        overview(path)


@pytest.mark.parametrize("share", [0.4, 0.7, 0.99])
def test_a_file_without_chunks_that_was_not_closed_is_saved_as_far_as_it_goes(
    tmp_path: Path, source: Source, share: float
) -> None:
    path = write(tmp_path / "run.mcap", source.entries, source.records, Kind(chunked=False))
    data = path.read_bytes()
    path.write_bytes(data[: round(share * len(data))])
    with pytest.raises(RecordingError, match="it was not closed"):
        read_bag(path)
    saved = recover(path)
    assert saved.losses
    assert 0 < saved.steps <= STEPS
    assert_part(read_bag(saved.path, steps=(0, saved.steps)), source.run, slice(0, saved.steps))


@given(kind=KINDS, dropped=st.sets(st.integers(0, 200), min_size=1, max_size=3))
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_missing_messages_are_never_passed_over(folder: Path, source: Source, kind: Kind, dropped: set[int]) -> None:
    entries, records, whole = source.entries, source.records, source.run
    samples = [n for n, entry in enumerate(entries) if entry.type.endswith(("/ContactForces", "/AxleStress"))]
    gone = {samples[number % len(samples)] for number in dropped}
    path = write(folder / "less.mcap", [e for n, e in enumerate(entries) if n not in gone], records, kind)
    with pytest.raises(RecordingError, match="incomplete without"):
        read_bag(path)
    found = overview(path)
    assert not found.complete
    assert found.steps == STEPS - LENGTH * len({entries[n].time_ns for n in gone})
    assert any("incomplete without" in str(loss) for loss in found.losses)
    losses: list[object] = []
    part = read_bag(path, lost=losses.append)
    assert len(part) == found.steps
    assert any("incomplete without" in str(loss) for loss in losses)
    np.testing.assert_array_equal(part.forces, whole.forces[part.steps.astype(int)])


def test_an_index_that_names_some_channels_alone_is_completed(tmp_path: Path, source: Source) -> None:
    """Without statistics and without lists of channels, nothing in it says that it lacks some."""
    path = write(tmp_path / "run.mcap", source.entries, source.records, Kind(statistics=False, offsets=False))
    data = path.read_bytes()
    start = struct.unpack_from("<Q", data, len(data) - 28)[0]
    place, end, topics = start, b"", 0
    while data[place] != Opcode.FOOTER:
        following = place + 9 + struct.unpack_from("<Q", data, place + 1)[0]
        topics += data[place] == Opcode.CHANNEL
        if data[place] != Opcode.CHANNEL or topics <= 3:
            end += data[place:following]
        place = following
    footer = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, 0)
    crc = zlib.crc32(end + footer)
    path.write_bytes(data[:start] + end + footer + struct.pack("<I", crc) + MAGIC)
    assert topics > 3
    assert_part(read_bag(path), source.run, slice(None))
    assert overview(path).complete
