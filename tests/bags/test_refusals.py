"""Bags that cannot be written or read: one clear line, and nothing half-written."""

import dataclasses
import os
import resource
from pathlib import Path

import pytest

from wheelset_track_sim.bags import Bag, BagWriter, blocks, read_bag
from wheelset_track_sim.bags.bag_reader import beside
from wheelset_track_sim.bags.messages import chunk_messages
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.live import run_messages
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

NAMES = ("run.mcap", "run")


def record(path, info, given):
    with BagWriter(path, info, start_ns=0) as bag:
        for block in given:
            bag.write(block)


def one_line(error) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize("name", NAMES)
def test_an_existing_bag_is_left_alone(tmp_path, run_info, run_blocks, name):
    path = tmp_path / name
    record(path, run_info, run_blocks)
    with pytest.raises(InputError, match="exists already") as error:
        BagWriter(path, run_info, start_ns=0)
    assert str(path) in one_line(error)
    assert len(read_bag(path)) == 2090


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_that_cannot_be_written(tmp_path, run_info, name):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(InputError, match=r"cannot be written.*give a path") as error:
        BagWriter(tmp_path / "file" / name, run_info, start_ns=0)
    one_line(error)
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("name", NAMES)
def test_a_disk_that_is_full_at_once_leaves_nothing_in_the_way(tmp_path, run_info, name):
    """A limit on the size of files stands for it."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        with pytest.raises(InputError, match=r"cannot be written.*give a path") as error:
            BagWriter(tmp_path / name, run_info, start_ns=0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    one_line(error)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", NAMES)
def test_failure_before_the_first_sample_leaves_nothing(tmp_path, run_info, name):
    with pytest.raises(ZeroDivisionError), BagWriter(tmp_path / name, run_info, start_ns=0):
        1 / 0  # noqa: B018
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", NAMES)
def test_failure_on_the_way_keeps_what_was_recorded(tmp_path, run_info, run_blocks, name):
    path = tmp_path / name
    with pytest.raises(ZeroDivisionError):
        record(path, run_info, (block if block is run_blocks[0] else 1 / 0 for block in run_blocks))
    assert len(read_bag(path)) == len(run_blocks[0])


def test_a_closed_bag_takes_nothing_more(tmp_path, run_info, run_blocks):
    bag = BagWriter(tmp_path / "run.mcap", run_info, start_ns=0)
    bag.write(run_blocks[0])
    bag.close()
    bag.close()
    with pytest.raises(RecordingError, match="is closed"):
        bag.write(run_blocks[1])


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")  # noqa: PTH110
def test_a_full_disk_is_told_in_one_line(tmp_path, run_info, run_blocks):
    bag = BagWriter(tmp_path / "run.mcap", run_info, start_ns=0)
    with open("/dev/full", "wb") as full:  # noqa: PTH123
        os.dup2(full.fileno(), bag._file._stream.fileno())
    bag.write(run_blocks[0])
    with pytest.raises(RecordingError, match=r"No space left.*free space") as error:
        bag.close()
    one_line(error)


def test_a_missing_bag(tmp_path):
    with pytest.raises(RecordingError, match="does not exist") as error:
        read_bag(tmp_path / "none.mcap")
    one_line(error)


def test_a_folder_without_a_bag(tmp_path):
    with pytest.raises(RecordingError, match=r"holds no \.mcap or \.db3 file"):
        read_bag(tmp_path)


@pytest.mark.parametrize("content", [b"", b"speed: 3\n" * 100, bytes(5000)])
def test_another_kind_of_file(tmp_path, content):
    path = tmp_path / "run.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match="is neither MCAP" if content else "not a complete bag") as error:
        read_bag(path)
    one_line(error)


@pytest.mark.parametrize("part", [0.01, 0.3, 0.6, 0.9, 0.99])
def test_a_truncated_bag(tmp_path, run_info, run_blocks, part):
    path = tmp_path / "run.mcap"
    record(path, run_info, run_blocks)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * part)])
    with pytest.raises(RecordingError, match=r"not a complete bag.*was not closed") as error:
        read_bag(path)
    one_line(error)


def test_no_flipped_byte_passes_for_data(tmp_path, run_info, run_blocks):
    path = tmp_path / "run.mcap"
    record(path, run_info, run_blocks)
    whole, forces = path.read_bytes(), read_bag(path).forces.tobytes()
    for place in range(0, len(whole), len(whole) // 97):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        try:
            found = read_bag(path)
        except RecordingError:
            continue
        assert found.forces.tobytes() == forces, f"byte {place}"


def test_a_gap_is_found(tmp_path, run_info, run_blocks):
    path = tmp_path / "run.mcap"
    record(path, run_info, [run_blocks[0], run_blocks[2]])
    with pytest.raises(RecordingError, match="gap, step 1390 follows step 1388") as error:
        list(blocks(path))
    one_line(error)


def test_a_bag_without_a_run(tmp_path, run_info, run_blocks, make_state):
    path = tmp_path / "run.mcap"
    with BagWriter(path, run_info, start_ns=0) as bag:
        bag.write_state(make_state(run_blocks[0]))
    with pytest.raises(RecordingError, match="holds no complete chunk"):
        list(Bag(path).events())


def test_decimated_samples_are_no_run(tmp_path, run_blocks, run_info):
    path = tmp_path / "thin.mcap"
    with BagWriter(path, run_info, start_ns=0) as bag:
        bag.write(dataclasses.replace(run_blocks[0], decimation=10))
    with pytest.raises(
        RecordingError, match=r"only every 10th step of /wheelset_track_sim/\S+: record it at full rate"
    ):
        read_bag(path)


@pytest.mark.parametrize(
    ("bag", "page"), [("run.mcap", "run.html"), ("run.1", "run.1.html"), (".", "../in.html"), ("..", "../../up.html")]
)
def test_a_page_beside_a_bag_wherever_one_is(bag, page, tmp_path, monkeypatch):
    (tmp_path / "up" / "in").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "up" / "in")
    assert beside(Path(bag), ".html").resolve() == Path(page).resolve()


@pytest.mark.parametrize("name", NAMES)
def test_what_is_broken_off_within_a_chunk_leaves_no_half_of_it(tmp_path, run_info, run_blocks, name):
    """As Ctrl-C does while messages are made."""
    path = tmp_path / name

    first, second, *_ = chunk_messages(run_blocks[1], 0)

    def broken_off():
        with BagWriter(path, run_info, start_ns=0) as bag:
            bag.write(run_blocks[0])
            bag.write_messages([first, dataclasses.replace(second, fields={})])

    with pytest.raises(KeyError):
        broken_off()
    losses = []
    assert [len(block) for block in Bag(path, losses.append).blocks()] == [1389]
    assert losses == []


def test_a_run_that_is_broken_off_before_it_begins_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(state, start_ns):
        raise KeyboardInterrupt

    simulator = Simulator(load_scenario("undamaged"))
    monkeypatch.setattr(run_messages, "state_message", interrupted)
    with pytest.raises(KeyboardInterrupt), run_messages.record(tmp_path / "run", simulator):
        pass
    assert [*tmp_path.iterdir()] == []
