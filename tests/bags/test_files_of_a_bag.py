"""Which files of a folder belong to a bag, and in which order: metadata.yaml says it, or their content."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from support.rewriting import entries_of, write
from wheelset_track_sim.bags import BagWriter, RunInfo, State, read_bag
from wheelset_track_sim.bags.folder_metadata import listed_files
from wheelset_track_sim.bags.overview import overview
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.bags.recover import recover
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError, NoBagError, RecordingError
from wheelset_track_sim.samples.block import SampleBlock

NAMES = ("2026-11-30T10.mcap", "2026-12-01T09.mcap", "zero.MCAP", "a 10.mcap", "a 9.mcap", "run_0.mcap", "run_007.mcap")
STEPS = 2090


@pytest.fixture
def parts(
    tmp_path: Path, run_info: RunInfo, run_blocks: list[SampleBlock], make_state: Callable[[SampleBlock], State]
) -> list[Path]:
    """The three files of a bag, in their order."""
    with BagWriter(tmp_path / "run", run_info, start_ns=10**18) as writer:
        writer.write_state(make_state(run_blocks[0]))
        for block in run_blocks:
            writer.write(block)
            if block is not run_blocks[-1]:
                writer.split()
    return [tmp_path / "run" / f"run_{number}.mcap" for number in range(3)]


def bag_of(folder: Path, parts: Sequence[Path], names: Sequence[str], listed: Sequence[str] = ()) -> Path:
    """A folder with the files under other names; ``metadata.yaml`` lists some, if any are given."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for part, name in zip(parts, names, strict=True):
        shutil.copy(part, folder / name)
    if listed:
        lines = [f"  - {name}" for name in listed]
        text = "\n".join(["rosbag2_bagfile_information:", "  version: 9", "  relative_file_paths:", *lines, ""])
        (folder / "metadata.yaml").write_text(text)
    return folder


@given(names=st.lists(st.sampled_from(NAMES), min_size=3, max_size=3, unique=True), listed=st.booleans())
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_names_do_not_matter(parts: list[Path], names: list[str], listed: bool) -> None:
    bag = bag_of(parts[0].parent.with_name("bag"), parts, names, names if listed else ())
    assert read_bag(bag).steps.tolist() == [*range(STEPS)]
    found = overview(bag)
    assert (found.steps, list(found.files), found.gaps) == (STEPS, names, ())
    assert found.complete == listed  # a folder without metadata.yaml lacks something
    with RecordedBag(bag) as played:
        times = [item.time_ns for item in played.messages(0, 2**62, {*played.topics})]
    assert times == sorted(times)


def test_files_beside_those_that_are_listed_are_left_out_and_named(parts: list[Path], tmp_path: Path) -> None:
    names = ["run_0.mcap", "run_1.mcap", "run_2.mcap"]
    bag = bag_of(tmp_path / "bag", parts, names, names)
    shutil.copy(bag / "run_0.mcap", bag / "run_0 (copy).mcap")
    assert len(read_bag(bag)) == STEPS
    found = overview(bag)
    assert found.complete
    assert "run_0 (copy).mcap: metadata.yaml does not list it is left out" in found.unchecked


@pytest.mark.parametrize("copy", ["a.mcap", "run_0 (copy).mcap", "zz.MCAP"])
def test_a_copy_counts_once(parts: list[Path], tmp_path: Path, copy: str) -> None:
    bag = bag_of(tmp_path / "bag", parts, ["run_0.mcap", "run_1.mcap", "run_2.mcap"])
    shutil.copy(bag / "run_0.mcap", bag / copy)
    assert read_bag(bag).steps.tolist() == [*range(STEPS)]
    assert recover(bag).steps == STEPS
    assert sum("is a copy of" in line for line in overview(bag).unchecked) == 1


def test_a_copy_that_was_cut_off_is_no_part(parts: list[Path], tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", parts, ["run_0.mcap", "run_1.mcap", "run_2.mcap"])
    content = parts[2].read_bytes()
    (bag / "backup.mcap").write_bytes(content[: len(content) - 100])
    losses: list[object] = []
    assert read_bag(bag, lost=losses.append).steps.tolist() == [*range(STEPS)]
    assert any("backup.mcap: left out, for it begins as run_2.mcap does" in str(loss) for loss in losses)
    with pytest.raises(RecordingError, match=r"backup.mcap.* left out, for it begins as run_2.mcap does"):
        read_bag(bag)


def test_only_files_of_the_folder_are_read(parts: list[Path], tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", parts[:1], ["run_0.mcap"], ["../run/run_1.mcap", "run_0.mcap"])
    losses: list[object] = []
    assert len(read_bag(bag, lost=losses.append)) == 1389
    assert [str(loss) for loss in losses] == ["run_1.mcap: it is missing"]


BOMB = "\n".join(
    ["rosbag2_bagfile_information:", "  l0: &l0 [x, x, x, x, x, x, x, x, x]"]
    + [f"  l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 9)}]" for n in range(1, 10)]
    + ["  relative_file_paths: *l9", ""]
)
LIST = "rosbag2_bagfile_information:\n  relative_file_paths:\n"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (BOMB, "holds an alias"),
        (f"{LIST}  - {'a' * 4000}.mcap\n", "a name of 4005 characters, and 1000 are allowed"),
        ("rosbag2_bagfile_information:\n  relative_file_paths: 5\n", "is not a list of up to"),
        ("rosbag2_bagfile_information: [1]\n", "is not a list of up to|has an entry that is not a file name"),
        (f"{LIST}  - 5\n", "has an entry that is not a file name"),
        (f"{LIST}  - {{a: 1}}\n", "has an entry that is not a file name"),
        (f"{LIST}  - ..\n  - ''\n", "has an entry that is not a file name"),
        ("a: [", "is not YAML"),
        ("\0", "is not text"),
        ("", "is not a list"),
    ],
)
def test_metadata_that_lists_nothing(parts: list[Path], tmp_path: Path, text: str, reason: str) -> None:
    bag = bag_of(tmp_path / "bag", parts, ["c.mcap", "b.mcap", "a.mcap"])
    (bag / "metadata.yaml").write_text(text)
    with pytest.raises(InputError, match=reason):
        listed_files(bag)
    losses: list[object] = []
    assert len(read_bag(bag, lost=losses.append)) == STEPS
    assert [str(loss).startswith("metadata.yaml: it cannot be read") for loss in losses] == [True]


def test_a_long_name_is_missing_and_no_error(parts: list[Path], tmp_path: Path) -> None:
    bag = bag_of(tmp_path / "bag", parts[:1], ["run_0.mcap"], ["run_0.mcap", "b" * 400])
    assert [str(loss) for loss in overview(bag).losses] == [f"{'b' * 400}: it is missing"]


@pytest.mark.parametrize("suffix", [".mcap", ".MCAP", ".Mcap"])
def test_the_suffix_of_a_file_in_any_case(
    tmp_path: Path, run_info: RunInfo, run_blocks: list[SampleBlock], suffix: str
) -> None:
    path = tmp_path / f"run{suffix}"
    with BagWriter(path, run_info, start_ns=0) as writer:
        writer.write(run_blocks[0])
    assert path.is_file()
    assert len(read_bag(path)) == len(read_bag(tmp_path)) == 1389


def test_no_file_at_all(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text(f"{LIST}  - run_0.db3\n")
    with pytest.raises(NoBagError, match=r"holds no \.mcap or \.db3 file"):
        read_bag(tmp_path)


@pytest.mark.parametrize(("content", "status"), [(b"", 1), (b"speed: 3\n" * 100, 2), (bytes(5000), 2)])
@pytest.mark.parametrize("name", ["run.mcap", "README.md"])
@pytest.mark.parametrize("command", ["info", "report", "recover", "resimulate"])
def test_what_holds_nothing_does_not_end_with_status_0(
    tmp_path: Path, name: str, content: bytes, status: int, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    if command == "report":
        pytest.importorskip("bokeh", reason="the page needs the extra report")
    (tmp_path / name).write_bytes(content)
    assert main([command, str(tmp_path / name)]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1


def test_a_bag_of_summaries_alone_is_not_complete(parts: list[Path], tmp_path: Path) -> None:
    entries = [entry for part in parts for entry in entries_of(part)[0]]
    path = write(tmp_path / "summaries.mcap", [entry for entry in entries if entry.type.endswith("/LoadSummary")])
    found = overview(path)
    assert not found.complete
    assert found.steps == 0
    assert found.summary is not None
    assert str(found.losses[0]) == "summaries.mcap: steps 0 to 2089 have summaries and no complete samples"


def test_extremes_are_not_taken_for_those_of_steps_without_summary(parts: list[Path], tmp_path: Path) -> None:
    entries = [entry for part in parts for entry in entries_of(part)[0]]
    kept = [e for e in entries if not (e.type.endswith("/LoadSummary") and e.time_ns == entries[0].time_ns)]
    found = overview(write(tmp_path / "some.mcap", kept))
    assert found.steps == STEPS
    assert [str(loss) for loss in found.losses] == [
        "some.mcap: steps 0 to 1388 have no summary, so the extremes are without them"
    ]
    assert np.isfinite(found.duration)
