"""Bags that go on in further files by size or by time, and whose oldest files are removed."""

import dataclasses

import numpy as np
import pytest
from mcap.reader import make_reader

from wheelset_track_sim.bags import BagWriter, RecordSettings, State, read_bag
from wheelset_track_sim.bags.bag import Bag
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.yaml12 import parse

START_NS = 1_700_000_000_000_000_000
SAMPLES = 1389
"""Of a block: 50 ms."""


@pytest.fixture
def record(tmp_path, run_info, make_block, make_state):
    """Record blocks of 50 ms with the settings given; the state is told at the start and where ``revised`` says."""

    def record(blocks, first=0, revised=(), **settings):
        path = tmp_path / "run"
        with BagWriter(path, run_info, start_ns=START_NS, settings=RecordSettings(**settings)) as bag:
            revision = 0
            for number in range(first, first + blocks):
                revision += number in revised
                block = make_block(SAMPLES * number, SAMPLES, time=number * 0.05, revision=revision)
                if number == first or number in revised:
                    bag.write_state(make_state(block))
                bag.write(block)
                sizes = [file.stat().st_size for file in path.glob("*.mcap")]
                assert sum(sizes) <= settings.get("max_total_size", np.inf)
        return path

    return record


def metadata(path):
    return parse((path / "metadata.yaml").read_text(), "metadata.yaml")["rosbag2_bagfile_information"]


def files_of(path):
    return [path / name for name in metadata(path)["relative_file_paths"]]


def test_files_end_before_they_are_too_large(record):
    path = record(60, max_size=2_000_000)
    files = files_of(path)
    assert sorted(path.glob("*.mcap")) == sorted(files)
    assert len(files) > 3
    sizes = [file.stat().st_size for file in files]
    assert max(sizes) <= 2_000_000
    assert min(sizes[:-1]) > 1_200_000  # two chunks of the file, uncompressed, are left free at most
    np.testing.assert_array_equal(read_bag(path).steps, np.arange(60 * SAMPLES))


@pytest.mark.parametrize("first", [0, 1000])
def test_files_are_as_long_as_asked_for(record, first):
    path = record(50, first, max_duration=1.0)
    recordings = [read_bag(file) for file in files_of(path)]
    assert [len(part) for part in recordings] == [20 * SAMPLES, 20 * SAMPLES, 10 * SAMPLES]


def test_each_file_begins_with_the_state_in_force(record, make_block, make_state, run_info):
    path = record(50, revised=(7, 20, 33), max_duration=1.0)
    for file, begin, revision, before in zip(files_of(path), (0, 20, 40), (0, 2, 3), (0, 2, 4), strict=True):
        first = next(iter(Bag(file).events()))
        assert isinstance(first, State)
        expected = make_state(make_block(SAMPLES * begin, SAMPLES, time=begin * 0.05, revision=revision))
        assert first == expected
        info = Bag(file).info
        assert dataclasses.replace(info, inputs=()) == run_info
        assert [item.revision for item in info.inputs] == [*range(before)]  # all that went in up to there
    assert [state.first_step // SAMPLES for state in read_bag(path).states] == [0, 7, 20, 33, 40]


@pytest.mark.slow
def test_the_oldest_files_go_first_and_the_metadata_stay_true(record):
    path = record(200, revised=(100,), max_duration=1.0, max_total_size=24_000_000)
    told = metadata(path)
    files = files_of(path)
    assert sorted(path.glob("*.mcap")) == sorted(files)
    assert [int(file.stem.rpartition("_")[2]) for file in files] == [*range(10 - len(files), 10)]
    assert 18_000_000 < sum(file.stat().st_size for file in files) <= 24_000_000
    counts = {}
    for file, entry in zip(files, told["files"], strict=True):
        with file.open("rb") as stream:
            statistics = make_reader(stream, validate_crcs=True).get_summary()
        names = {number: channel.topic for number, channel in statistics.channels.items()}
        for number, count in statistics.statistics.channel_message_counts.items():
            counts[names[number]] = counts.get(names[number], 0) + count
        assert entry["path"] == file.name
        assert entry["message_count"] == statistics.statistics.message_count
        assert entry["starting_time"]["nanoseconds_since_epoch"] == statistics.statistics.message_start_time
    topics = {topic["topic_metadata"]["name"]: topic["message_count"] for topic in told["topics_with_message_count"]}
    assert topics == counts
    assert told["message_count"] == sum(counts.values())
    kept = read_bag(path)
    before_ns = round((kept.time[0] - 0.05) * 1e9)  # the state follows the last chunk of the file that was removed
    assert told["starting_time"]["nanoseconds_since_epoch"] == kept.start_ns + before_ns + 1
    np.testing.assert_array_equal(kept.steps, np.arange(kept.steps[0], 200 * SAMPLES))
    assert kept.states[0].first_step == kept.steps[0] > 0
    for file in files:
        part = read_bag(file)
        assert part.states[0].first_step == part.steps[0]


@pytest.mark.slow
def test_a_bound_on_all_is_enough(record):
    path = record(150, max_total_size=10_000_000)
    assert len(files_of(path)) >= 4
    assert read_bag(path).steps[-1] == 150 * SAMPLES - 1


def test_a_single_file_has_no_bounds(tmp_path, run_info):
    with pytest.raises(InputError, match="is a single file, which cannot be split: give a folder"):
        BagWriter(tmp_path / "run.mcap", run_info, start_ns=0, settings=RecordSettings(max_size=10**7))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("max_size", 1, r"^max_size = 1 bytes is out of range: give at least 1e\+06 bytes, or 0 for no limit$"),
        ("max_duration", 0.5, "^max_duration = 0.5 s is out of range: give at least 1 s, or 0 for no limit$"),
        ("max_total_size", 10**6, "^max_total_size = .* or 0 for no limit$"),
        ("max_size", -1, "^max_size = -1 bytes is out of range: give the size .* from 0 to"),
        ("max_duration", float("nan"), "^max_duration = nan is not finite"),
        ("mode", "snapshots", "^mode = 'snapshots' is not a known mode: did you mean snapshot"),
    ],
)
def test_bounds_that_make_no_sense_are_refused(name, value, message):
    with pytest.raises(InputError, match=message):
        RecordSettings(**{name: value})


def test_a_gap_begins_another_file_that_says_why(tmp_path, run_info, make_block, make_state):
    given = [make_block(0, SAMPLES), make_block(5 * SAMPLES, SAMPLES, time=0.25)]
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as bag:
        bag.write_state(make_state(given[0]))
        bag.write(given[0])
        bag.gap("steps 1389 to 6944 are lost")
        bag.write(given[1])
    before, after = (read_bag(file) for file in files_of(tmp_path / "run"))
    assert (before.steps[-1], after.steps[0]) == (SAMPLES - 1, 5 * SAMPLES)
    assert after.states == (dataclasses.replace(make_state(given[1]), message="steps 1389 to 6944 are lost"),)


def test_what_a_file_takes_at_most_is_known_before(tmp_path, run_info, make_block, make_state):
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as bag:
        bounds = []
        for number, samples in enumerate((1, 7, 500, 20_000, 3, 3, 3, 90_000)):
            block = make_block(number * 10**5, samples, time=number * 4.0)
            bag.write_state(make_state(block))
            bag.write(block)
            bounds.append(bag._file.bound)
            bag.split()
        sizes = [file.stat().st_size for file in files_of(tmp_path / "run")][: len(bounds)]
    for size, bound in zip(sizes, bounds, strict=True):
        assert size <= bound <= 1.5 * size + 10_000
