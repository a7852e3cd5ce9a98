"""Names of output files, and where they may be."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.runtime.output_files import file_name, require_folder, require_new


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("damage_wheel_1", "damage_wheel_1"),
        ("../x", "x"),
        ("/etc/passwd", "etc_passwd"),
        ("..", "unnamed"),
        ("", "unnamed"),
        (".hidden", "hidden"),
        ("-rf", "rf"),
        ("Rad links, 100 km/h", "Rad_links_100_km_h"),
        ("Zürich-7.2", "Zürich-7.2"),
        ("a\x1b[2J\udcff", "a_2J"),
    ],
)
def test_names_of_files(name, file):
    assert file_name(name) == file


@given(st.text() | st.text("./\\:~-\x00\x1b", max_size=20))
def test_a_name_leads_nowhere_else(name):
    file = file_name(name)
    assert Path(file).name == file
    assert (Path("/folder") / f"{file}.png").resolve().parent == Path("/folder")
    assert 1 <= len(file.encode()) <= 100
    assert file.isprintable()
    assert file_name(file) == file


def test_long_names_that_begin_alike_stay_apart():
    one, other = (file_name("Länge_" * 40 + end) for end in ("a", "b"))
    assert one != other
    assert one[:70] == other[:70]


def test_folders_are_not_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    require_folder(Path("run.mcap"))
    with pytest.raises(InputError, match=r"new/run.mcap cannot be written: its folder does not exist, create .*new"):
        require_folder(Path("new/run.mcap"))


def test_files_are_replaced_only_if_asked(tmp_path):
    there = tmp_path / "page.html"
    there.write_text("mine")
    require_new([tmp_path / "other.html"], overwrite=False)
    require_new([there], overwrite=True)
    with pytest.raises(InputError, match=r"page.html exists already: give another path, or --overwrite"):
        require_new([tmp_path / "other.html", there], overwrite=False)
