"""Snapshots: the time around impacts, each a bag of its own, in bounded memory."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from wheelset_track_sim.bags import RecordSettings, read_bag
from wheelset_track_sim.bags.bag_writer import BagWriter
from wheelset_track_sim.bags.snapshots import SnapshotWriter, writer_of
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.samples.impacts import Impact

SAMPLES = 1389
PERIOD = SAMPLES * 1e-3 / 27.7777778
"""Of a block, s."""


def impact(number, part=0.5):
    """An impact within block ``number``."""
    time = (number + part) * PERIOD
    step = round((number + part) * SAMPLES)
    return Impact(0, step, time, 27.8, step * 1e-3, 0, 0.0, 3e5, 1e5, 1e-3, 0.0, 2e5)


@pytest.fixture
def blocks(make_block):
    """Blocks of a run of any length."""

    def block(number):
        return make_block(SAMPLES * number, SAMPLES, time=number * PERIOD, revision=number // 30)

    return block


@pytest.fixture
def start(tmp_path, run_info):
    def start(name="run", **settings):
        return SnapshotWriter(tmp_path / name, run_info, start_ns=0, settings=RecordSettings("snapshot", **settings))

    return start


def run(writer, blocks, make_state, numbers, impacts):
    """Record blocks, with a state every 30 blocks, and impacts told at the end of the block behind theirs."""
    for number in numbers:
        if number % 30 == 0:
            writer.write_state(make_state(blocks(number)))
        over = [impact(number - 1)] if number - 1 in impacts else []
        writer.write(blocks(number), impacts=over)


def taken(writer):
    return sorted(writer.path.iterdir(), key=lambda path: int(path.name.rpartition("_")[2]))


def test_what_is_around_an_impact_is_a_bag_of_its_own(start, blocks, make_state, tmp_path, run_info):
    with start(snapshot_duration=1.0, snapshot_after=0.2) as writer:
        run(writer, blocks, make_state, range(200), {70, 150})
    first, second = taken(writer)
    assert first.name == f"run_step_{round(70.5 * SAMPLES)}"
    for path, number in ((first, 70), (second, 150)):
        found = read_bag(path)
        begin, end = int(found.steps[0]) // SAMPLES, int(found.steps[-1]) // SAMPLES
        before = (number + 0.5) * PERIOD - found.time[0]
        assert 1.0 <= before < 1.0 + 2 * PERIOD
        assert end == number + 1 + 4  # told with the next block, and 0.2 s after that
        np.testing.assert_array_equal(found.forces, np.concatenate([blocks(n).forces for n in range(begin, end + 1)]))
        state = make_state(blocks(begin))
        assert found.states[0] == dataclasses.replace(state, scenario=make_state(blocks(0)).scenario)
        assert [item.revision for item in found.info.inputs] == [*range(begin // 30 + 1)]
        assert (path / "metadata.yaml").exists()


@pytest.mark.slow
def test_each_opens_in_other_readers(start, blocks, make_state):
    with start(snapshot_duration=0.5) as writer:
        run(writer, blocks, make_state, range(80), {40})
    [path] = taken(writer)
    steps = int(path.name.rpartition("_")[2])
    with AnyReader([path]) as reader:
        messages = [
            reader.deserialize(data, item.msgtype)
            for item, _, data in reader.messages()
            if item.topic.endswith("/impacts")
        ]
    assert [message.step for message in messages] == [steps]
    with Reader(path) as reader:
        count = reader.message_count
        assert reader.start_time == min(time for _, time, _ in reader.messages())
    with (path / f"{path.name}_0.mcap").open("rb") as stream:
        decoded = [*make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()]
    assert len(decoded) == count
    forces = [message for _, channel, _, message in decoded if channel.topic.endswith("/contact_forces")]
    np.testing.assert_array_equal(np.diff([message.first_step for message in forces]), SAMPLES)


def test_impacts_in_a_snapshot_belong_to_it_and_nothing_is_written_twice(start, blocks, make_state):
    with start(snapshot_duration=0.5, snapshot_after=0.5) as writer:
        run(writer, blocks, make_state, range(100), {*range(20, 60)})
    spans = [(int(read_bag(path).steps[0]), int(read_bag(path).steps[-1])) for path in taken(writer)]
    assert len(spans) == 4
    for (_, end), (begin, _) in pairwise(spans):
        assert begin > end


def test_memory_is_bounded(start, blocks, make_state):
    writer = start(snapshot_duration=1.0)
    for number in range(100):
        writer.write(blocks(number))
        assert len(writer._kept) <= (1.0 + 1.0) / PERIOD + 1
    writer.close()
    assert taken(writer) == []


def test_taken_by_hand(start, blocks, make_state):
    writer = start(snapshot_duration=1.0)
    with pytest.raises(InputError, match="no sample has been recorded since the last snapshot"):
        writer.snapshot()
    run(writer, blocks, make_state, range(100), set())
    path = writer.snapshot()
    assert path.name == f"run_step_{100 * SAMPLES - 1}"
    found = read_bag(path)
    assert found.steps[-1] == 100 * SAMPLES - 1
    assert found.time[-1] - found.time[0] == pytest.approx(1.0, abs=2 * PERIOD)
    assert found.states[0].first_step == found.steps[0]
    with pytest.raises(InputError, match="no sample has been recorded since the last snapshot"):
        writer.snapshot()
    run(writer, blocks, make_state, range(100, 103), {101})
    assert writer.snapshot() == writer.path / f"run_step_{round(101.5 * SAMPLES)}"  # is being written
    with pytest.raises(InputError, match="nothing to split"):
        writer.split()
    writer.close()
    assert len(taken(writer)) == 2
    assert read_bag(taken(writer)[1]).steps[0] == 100 * SAMPLES


def test_no_snapshot_has_a_gap(start, blocks, make_state):
    with start(snapshot_duration=1.0, snapshot_after=0.1) as writer:
        run(writer, blocks, make_state, range(20), set())
        writer.gap("steps are lost")
        run(writer, blocks, make_state, range(25, 40), {28})
    [path] = taken(writer)
    assert read_bag(path).steps[0] == 25 * SAMPLES


@pytest.mark.slow
def test_the_oldest_go_first(start, blocks, make_state):
    with start(snapshot_duration=0.5, snapshot_after=0.3, max_total_size=10_000_000) as writer:
        run(writer, blocks, make_state, range(200), {20, 60, 100, 140, 180})
    kept = taken(writer)
    assert [path.name for path in kept] == [f"run_step_{round((n + 0.5) * SAMPLES)}" for n in (140, 180)]
    assert sum(file.stat().st_size for path in kept for file in path.glob("*.mcap")) <= 10_000_000
    for path in kept:
        assert len(read_bag(path)) > 10 * SAMPLES


def test_nothing_is_overwritten(start, tmp_path):
    (tmp_path / "run").mkdir()
    with pytest.raises(InputError, match="run exists already"):
        start("run")
    with pytest.raises(InputError, match="run exists already"):
        start("run.mcap")


def test_a_folder_in_the_way_ends_it_in_a_clear_error(start, blocks, make_state):
    writer = start(snapshot_duration=0.5)
    (writer.path / f"run_step_{round(20.5 * SAMPLES)}").mkdir()
    with pytest.raises(RecordingError, match="exists already"):
        run(writer, blocks, make_state, range(80), {20})


def test_the_mode_makes_the_writer(tmp_path, run_info):
    with writer_of(tmp_path / "one", run_info, RecordSettings(), start_ns=0) as writer:
        assert isinstance(writer, BagWriter)
    with writer_of(tmp_path / "two", run_info, RecordSettings("snapshot"), start_ns=0) as writer:
        assert isinstance(writer, SnapshotWriter)


def test_an_exception_without_an_impact_leaves_nothing(start, tmp_path):
    with pytest.raises(ZeroDivisionError), start():
        1 / 0  # noqa: B018
    assert list(tmp_path.iterdir()) == []
