"""What comes from around the program ends in one line, in real processes: pipes, full disks, names, folders."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import OLD_BAG, ROOT
from wheelset_track_sim.cli.ending import status_of
from wheelset_track_sim.errors import InputError, WheelsetTrackError

COMMAND = [sys.executable, "-m", "wheelset_track_sim"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "LC_ALL": "C.UTF-8"}
FULL = Path("/dev/full")
PRINTING = [("cache", "--json"), ("--help",), pytest.param(("info", str(OLD_BAG)), marks=pytest.mark.slow)]
"""Commands that print by print, by argparse and by rich."""
needs_full = pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")


def run(*arguments, **options):
    """Status, and lines on standard error."""
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "env": ENVIRONMENT} | options
    done = subprocess.run([*COMMAND, *arguments], check=False, **options)
    return done.returncode, (done.stderr or b"").decode(errors="replace").splitlines()


@pytest.mark.parametrize("arguments", PRINTING)
def test_a_reader_that_is_gone_is_told_nothing(arguments):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        status, lines = run(*arguments, stdout=writer)
    finally:
        os.close(writer)
    assert (status, lines) == (1, [])


@needs_full
@pytest.mark.parametrize("arguments", PRINTING)
def test_a_full_disk_behind_standard_output(arguments):
    with FULL.open("w") as full:
        status, lines = run(*arguments, stdout=full)
    assert status == 1
    assert lines == [
        "wheelset-track-sim: standard output cannot be written (No space left on device): make room, or send it "
        "elsewhere"
    ]


@needs_full
def test_a_full_disk_behind_standard_error_changes_no_status():
    with FULL.open("w") as full:
        assert run("info", "nothing", stderr=full) == (2, [])


def test_too_little_memory_is_one_line(capsys):
    def command():
        raise MemoryError

    assert status_of(command, "program") == 1
    assert capsys.readouterr().err == "program: there is not enough memory: give a smaller input, or a higher limit\n"


def test_a_working_folder_that_has_been_removed(tmp_path):
    gone = tmp_path / "gone"
    code = f"import os, sys; os.mkdir({str(gone)!r}); os.chdir({str(gone)!r}); os.rmdir({str(gone)!r}); "
    code += f"os.execv(sys.executable, [sys.executable, '-m', 'wheelset_track_sim', 'info', {str(OLD_BAG)!r}])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False, env=ENVIRONMENT)
    assert done.returncode == 2
    assert done.stderr.decode().splitlines() == [
        "wheelset-track-sim: the working folder has been removed: change to one that exists"
    ]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["info", "report", "recover"])
@pytest.mark.parametrize("locale", ["C.UTF-8", "C"])
def test_file_names_that_are_not_utf_8(tmp_path, command, locale):
    bag = os.fsencode(tmp_path) + b"/run_\xff.mcap"
    shutil.copy(OLD_BAG, bag)
    status, lines = run(command, bag, env={**ENVIRONMENT, "LC_ALL": locale})
    assert (status, lines) == (0, [])
    made = {os.fsencode(path.name) for path in tmp_path.iterdir()} - {b"run_\xff.mcap"}
    assert (
        made
        == {
            "info": set(),
            "report": {b"run_\xff.html", b"run_\xff.png"},
            "recover": {b"run_\xff_recovered"},
        }[command]
    )
    if command == "recover":
        status, lines = run("info", os.fsencode(tmp_path) + b"/run_\xff_recovered")
        assert (status, lines) == (0, [])


def test_such_a_name_of_nothing_is_one_line():
    status, lines = run("info", b"/tmp/nothing_\xff.mcap")
    assert status == 2
    assert len(lines) == 1
    assert r"nothing_\udcff.mcap" in lines[0]


@pytest.mark.ros
@pytest.mark.slow
@pytest.mark.parametrize("variable", ["HOME", "ROS_LOG_DIR"])
def test_a_log_folder_that_cannot_be_written(tmp_path, variable):
    """A file where the folder should be: this stops root, too."""
    (tmp_path / "file").write_text("")
    environment = {key: value for key, value in ENVIRONMENT.items() if key not in ("ROS_LOG_DIR", "ROS_HOME")}
    status, lines = run("replay", str(OLD_BAG), env=environment | {variable: str(tmp_path / "file")})
    assert status == 2
    assert len(lines) == 1
    assert "ROS cannot write its log" in lines[0]
    assert "set ROS_LOG_DIR or HOME to a folder that can be written" in lines[0]


@pytest.mark.parametrize("arguments", [("run", "."), ("study", "."), ("stress", "."), ("info", "."), ("report", ".")])
def test_a_directory_given_for_a_file(tmp_path, capsys, monkeypatch, arguments):
    from wheelset_track_sim.cli import main

    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(
    ("raised", "status", "line"),
    [
        (InputError("speed = 1: give 2"), 2, "p: speed = 1: give 2"),
        (WheelsetTrackError("failed"), 1, "p: failed"),
        (IsADirectoryError(21, "Is a directory", "x"), 2, "p: x cannot be used (Is a directory): give another path"),
        (OSError(28, "No space left on device", "x.png"), 1, "p: x.png: No space left on device: remove the cause"),
        (OSError(5, "Input/output error"), 1, "p: Input/output error: remove the cause, and try again"),
        (PermissionError(13, "Permission denied", b"\xff"), 2, r"p: \udcff cannot be used (Permission denied)"),
        (UnicodeEncodeError("utf-8", "x\udcff", 1, 2, "surrogates"), 2, r"p: 'x\udcff' is not UTF-8: rename"),
        (KeyboardInterrupt(), 1, "p: interrupted"),
    ],
)
def test_each_end_is_one_line_and_a_status(capsys, raised, status, line):
    def command():
        raise raised

    assert status_of(command, "p") == status
    error = capsys.readouterr().err
    assert error.startswith(line)
    assert len(error.splitlines()) == bool(line)


def test_a_fault_of_the_program_keeps_its_traceback():
    with pytest.raises(ZeroDivisionError):
        status_of(lambda: 1 // 0, "p")
