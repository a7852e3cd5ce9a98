"""Names of bags that come over ROS, and the recorder's own promises, without ROS."""

import errno

import pytest

from wheelset_track_sim.errors import InputError, RecordingError
from wheelset_track_sim.recording import read
from wheelset_track_sim.recording.messages import chunk_messages
from wheelset_track_sim.ros.recorder import LONGEST_NAME, Recorder, name_now, path_below


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
    with pytest.raises(InputError, match=f"^name = .* leads out of {folder}"):
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
def recorder(monkeypatch, run_info):
    monkeypatch.setattr("wheelset_track_sim.ros.recorder.run_info", lambda simulator: run_info)
    return Recorder("/wheelset_track_sim")


def test_one_bag_at_a_time(recorder, tmp_path, run_blocks):
    assert recorder.stop() == ""
    with pytest.raises(InputError, match="nothing is being recorded"):
        recorder.split()
    recorder.start(tmp_path / "run", None, 0)
    with pytest.raises(InputError, match=f"{tmp_path / 'run'} is being recorded: stop it first"):
        recorder.start(tmp_path / "other", None, 0)
    recorder.write(chunk_messages(run_blocks[0], 0))
    assert recorder.split() == tmp_path / "run" / "run_1.mcap"
    recorder.write(chunk_messages(run_blocks[1], 0))
    assert recorder.path == recorder.stop() == str(tmp_path / "run")
    assert recorder.path == ""
    assert len(read(tmp_path / "run")) == 1390
    with pytest.raises(InputError, match="exists already"):
        recorder.start(tmp_path / "run", None, 0)
    assert recorder.path == ""


def test_a_full_disk_ends_the_recording_and_another_can_begin(recorder, tmp_path, run_blocks, monkeypatch):
    recorder.start(tmp_path / "run", None, 0)

    def full(self):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("wheelset_track_sim.recording.mcap_file.McapFile.flush", full)
        recorder.write(chunk_messages(run_blocks[0], 0))  # is still in memory
        with pytest.raises(RecordingError, match="No space left"):
            recorder.split()
    assert recorder.path == ""
    assert "No space left" in str(recorder.lost)
    recorder.start(tmp_path / "again", None, 0)
    assert recorder.lost is None
    recorder.write(chunk_messages(run_blocks[0], 0))
    recorder.stop()
    assert len(read(tmp_path / "again")) == len(run_blocks[0])


@pytest.mark.parametrize("name", ["run{}", "run{}.mcap"])
def test_the_bags_of_the_next_runs_go_beside_the_first(recorder, tmp_path, name):
    recorder.start(tmp_path / name.format(""), None, 0)
    recorder.stop()
    (tmp_path / name.format("_3")).mkdir()
    for number in (2, 4, 5):
        path = recorder.beside()
        assert path == tmp_path / name.format(f"_{number}")
        recorder.start(path, None, 0)
        recorder.stop()
    recorder.start(tmp_path / "other", None, 0)
    recorder.stop()
    assert recorder.beside() == tmp_path / "other_2"
