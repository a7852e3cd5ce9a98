"""A bag of several files: one run, and each file a bag of its own."""

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from wheelset_track_sim.bags import BagWriter, read_bag
from wheelset_track_sim.bags.run_info import Input
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.inputs.yaml12 import parse

START_NS = 1_700_000_000_000_000_000


@pytest.fixture
def split_bag(tmp_path, run_info, run_blocks, make_state):
    """A bag of three files with a block each; the middle one is told no state, and tells that of the first again."""
    path = tmp_path / "run"
    with BagWriter(path, run_info, start_ns=START_NS) as bag:
        bag.write_state(make_state(run_blocks[0]))
        bag.write(run_blocks[0])
        assert bag.split() == path / "run_1.mcap"
        bag.write(run_blocks[1])
        assert bag.split() == path / "run_2.mcap"
        bag.write_state(make_state(run_blocks[2]))
        bag.write(run_blocks[2])
    return path


def test_the_run_comes_back_whole(split_bag, run_blocks, make_state):
    found = read_bag(split_bag)
    np.testing.assert_array_equal(found.forces, np.concatenate([block.forces for block in run_blocks]))
    np.testing.assert_array_equal(found.steps, np.arange(2090))
    again = make_state(run_blocks[1])
    assert found.states == (make_state(run_blocks[0]), again, make_state(run_blocks[2]))


def test_each_file_can_be_read_alone(split_bag, run_blocks, run_info, make_state):
    start = Input(0, 0, make_state(run_blocks[0]).scenario)
    for number, block in enumerate(run_blocks):
        found = read_bag(split_bag / f"run_{number}.mcap")
        assert found.info == (run_info.with_input(start) if number else run_info)  # what went in before the file
        assert found.start_ns == START_NS
        np.testing.assert_array_equal(found.forces, block.forces)


def test_rosbags_reads_all_files_and_their_metadata_tell_them_apart(split_bag, run_blocks):
    with Reader(split_bag) as reader:
        assert reader.message_count == sum(1 for _ in reader.messages()) == 3 * 5 + 3
        assert reader.start_time == START_NS
    metadata = parse((split_bag / "metadata.yaml").read_text(), "metadata.yaml")["rosbag2_bagfile_information"]
    files = metadata["files"]
    assert metadata["relative_file_paths"] == [file["path"] for file in files] == [f"run_{n}.mcap" for n in range(3)]
    assert metadata["message_count"] == sum(file["message_count"] for file in files) == 3 * 5 + 3
    starts = [file["starting_time"]["nanoseconds_since_epoch"] - START_NS for file in files]
    ends = [start + file["duration"]["nanoseconds"] for start, file in zip(starts, files, strict=True)]
    assert ends == pytest.approx([1e9 * block.time for block in run_blocks], abs=1)
    assert starts == [0, ends[0] + 1, ends[1] + 1]  # a file goes on where the one before has ended


def test_metadata_are_complete_while_a_later_file_is_written(tmp_path, run_info, run_blocks):
    bag = BagWriter(tmp_path / "run", run_info, start_ns=START_NS)
    bag.write(run_blocks[0])
    bag.split()
    text = (tmp_path / "run" / "metadata.yaml").read_text()
    assert "run_0.mcap" in text
    assert "run_1.mcap" in text
    assert "message_count: 5" in text
    bag.close()
    np.testing.assert_array_equal(read_bag(tmp_path / "run").forces, run_blocks[0].forces)  # the second one is empty


def test_a_first_file_without_samples_hides_nothing(tmp_path, run_info, run_blocks, make_state):
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as bag:
        bag.write_state(make_state(run_blocks[0]))
        bag.split()
        bag.write(run_blocks[0])
    np.testing.assert_array_equal(read_bag(tmp_path / "run").stresses, run_blocks[0].stresses)


def test_what_cannot_be_split(tmp_path, run_info, run_blocks):
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as bag:
        with pytest.raises(InputError, match=r"run_0\.mcap holds nothing yet"):
            bag.split()
        bag.write(run_blocks[0])
    with pytest.raises(RecordingError, match="closed"):
        bag.split()
    with BagWriter(tmp_path / "run.mcap", run_info, start_ns=START_NS) as bag:
        bag.write(run_blocks[0])
        with pytest.raises(InputError, match="single file"):
            bag.split()
        bag.write(run_blocks[1])
    assert len(read_bag(tmp_path / "run.mcap")) == 1390


def test_a_file_in_the_way_ends_the_bag_and_keeps_what_was_recorded(tmp_path, run_info, run_blocks):
    with BagWriter(tmp_path / "run", run_info, start_ns=START_NS) as bag:
        bag.write(run_blocks[0])
        (tmp_path / "run" / "run_1.mcap").write_text("not ours")
        with pytest.raises(RecordingError, match="cannot be written further"):
            bag.split()
    assert (tmp_path / "run" / "run_1.mcap").read_text() == "not ours"
    assert len(read_bag(tmp_path / "run" / "run_0.mcap")) == 1389
