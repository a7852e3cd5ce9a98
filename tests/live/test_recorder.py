"""Names of bags that come over ROS, and the recorder's own promises, without ROS."""

import os

import pytest

from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.bags.messages import chunk_messages
from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.live.recorder import LONGEST_NAME, Recorder, name_now, path_below
from wheelset_track_sim.monitoring.status import recording_status
from wheelset_track_sim.verdict.limit_set import Level


@pytest.fixture
def folder(tmp_path):
    """The folder of the recordings, beside one that is none of its business."""
    (tmp_path / "secret").mkdir()
    (tmp_path / "recordings" / "day").mkdir(parents=True)
    return tmp_path / "recordings"


@pytest.mark.parametrize("name", ["run", "day/run", "day/new/run", "run.mcap", "./run", "Lauf 1 übers Gleis", "..run"])
def test_names_below_the_folder(folder, name):
    path = path_below(str(folder), name)
    assert folder in path.parents
    assert path == (folder / name).resolve()


LEADING_OUT = [
    "../run",
    "day/../../run",
    "day/../run",
    "/etc/run",
    "..",
    ".",
    "",
    "day/..",
    "link/run",
    "link",
    "loop/run",
]


@pytest.mark.parametrize("name", LEADING_OUT)
def test_names_that_lead_out_are_refused(folder, name):
    (folder / "link").symlink_to(folder.parent / "secret")
    (folder / "loop").symlink_to("loop")
    with pytest.raises(InputError, match=f"^name = .* points outside {folder}"):
        path_below(str(folder), name)


def test_a_link_within_the_folder_is_followed(folder):
    (folder / "today").symlink_to("day")
    assert path_below(str(folder), "today/run") == folder / "day" / "run"


def test_a_folder_that_is_a_link_itself(folder):
    (folder.parent / "link").symlink_to(folder)
    assert path_below(str(folder.parent / "link"), "run") == folder / "run"


@pytest.mark.parametrize("name", ["a\0b", "a\nb", "\x1b[2J", "a\x7f"])
def test_control_characters_are_refused(folder, name):
    with pytest.raises(InputError, match="cannot be printed"):
        path_below(str(folder), name)


def test_the_length_is_bounded_in_bytes(folder):
    assert path_below(str(folder), "x" * LONGEST_NAME).name == "x" * LONGEST_NAME
    with pytest.raises(InputError, match=f"has {2 * LONGEST_NAME} bytes: give at most {LONGEST_NAME}"):
        path_below(str(folder), "ü" * LONGEST_NAME)
    with pytest.raises(InputError, match="bytes") as refusal:
        path_below(str(folder), "x" * 10**6)
    assert len(str(refusal.value)) < 200


def test_a_fleet_has_names_of_its_own():
    assert name_now("/wheelset_track_sim").count("_") == 2
    assert name_now("/bogie/leading").endswith("_bogie_leading")


@pytest.fixture
def told():
    """What was logged."""
    return []


@pytest.fixture
def recorder(monkeypatch, run_info, told):
    monkeypatch.setattr("wheelset_track_sim.live.recorder.run_info", lambda simulator: run_info)
    return Recorder("/wheelset_track_sim", told.append)


def begin(recorder, path):
    recorder.take(recorder.open(path, None, 0))


def test_one_bag_at_a_time(recorder, tmp_path, run_blocks):
    assert recorder.stop().result() == ""
    with pytest.raises(InputError, match="nothing is being recorded"):
        _ = recorder.bag
    begin(recorder, tmp_path / "run")
    with pytest.raises(InputError, match=f"{tmp_path / 'run'} is being recorded: stop it first"):
        begin(recorder, tmp_path / "other")
    assert not (tmp_path / "other").exists()
    recorder.write(chunk_messages(run_blocks[0], 0))
    assert recorder.bag.split().result() == tmp_path / "run" / "run_1.mcap"
    recorder.write(chunk_messages(run_blocks[1], 0))
    assert recorder.path == recorder.stop().result() == str(tmp_path / "run")
    assert recorder.path == ""
    assert len(read_bag(tmp_path / "run")) == 1390
    with pytest.raises(InputError, match="exists already"):
        begin(recorder, tmp_path / "run")
    assert recorder.path == ""
    assert recording_status(recorder.figures).level == Level.ERROR
    assert recording_status(recorder.figures).message.startswith(f"not started: {tmp_path / 'run'} exists already")
    begin(recorder, tmp_path / "other")
    assert (recording_status(recorder.figures).level, recording_status(recorder.figures).message) == (
        Level.OK,
        f"to {tmp_path / 'other'}",
    )
    recorder.stop().result()
    assert recording_status(recorder.figures).message == "none"


def test_of_two_that_begin_at_once_one_is_taken(recorder, tmp_path, run_blocks):
    first, second = (recorder.open(tmp_path / name, None, 0) for name in ("first", "second"))
    recorder.take(first)
    with pytest.raises(InputError, match="first is being recorded: stop it first"):
        recorder.take(second)
    recorder.write(chunk_messages(run_blocks[0], 0))
    recorder.stop().result()
    assert len(read_bag(tmp_path / "first")) == len(run_blocks[0])


def test_a_full_disk_ends_the_recording_and_another_can_begin(recorder, told, tmp_path, run_blocks):
    """The device that is always full, in the place of the file."""
    begin(recorder, tmp_path / "run")
    with open("/dev/full", "wb") as full:  # noqa: PTH123
        os.dup2(full.fileno(), recorder._bag._writer._file._stream.fileno())
    recorder.write(chunk_messages(run_blocks[0], 0))  # is still in memory
    with pytest.raises(RecordingError, match="No space left"):
        recorder.bag.split().result()
    assert recorder.path == ""
    assert "No space left" in str(recorder.lost)
    [line] = told
    assert line == f"recording ends here: {recorder.lost}"
    assert recording_status(recorder.figures).level == Level.ERROR
    begin(recorder, tmp_path / "again")
    assert recorder.lost is None
    assert recording_status(recorder.figures).message == f"to {tmp_path / 'again'}"
    recorder.write(chunk_messages(run_blocks[0], 0))
    recorder.stop().result()
    assert len(read_bag(tmp_path / "again")) == len(run_blocks[0])


@pytest.mark.parametrize("name", ["run{}", "run{}.mcap"])
def test_the_bags_of_the_next_runs_go_beside_the_first(recorder, tmp_path, name):
    begin(recorder, tmp_path / name.format(""))
    recorder.stop().result()
    (tmp_path / name.format("_3")).mkdir()
    for number in (2, 4, 5):
        path = recorder.beside()
        assert path == tmp_path / name.format(f"_{number}")
        begin(recorder, path)
        recorder.stop().result()
    begin(recorder, tmp_path / "other")
    recorder.stop().result()
    assert recorder.beside() == tmp_path / "other_2"
