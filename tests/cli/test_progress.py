"""What is shown of slow work: in a log, and in a terminal."""

import io
import re

import pytest

from wheelset_track_sim.cli import progress
from wheelset_track_sim.cli.console import Terminal


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_log_has_a_line_for_each_job_and_one_now_and_then(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with progress.shown(clock) as told:
        for n in range(7):  # stages of one job: the share does not fall
            told(f"modes, n = {n}", n / 7)
        told("poles", 1.0)
        for ended in range(40, 101):  # 40 of 100 runs were there
            clock.now += 10.0
            told(f"study depth, {ended} of 100 runs", ended / 100)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "poles: done"
    assert lines[1] == "study depth, 43 of 100 runs: 43%, 9:30 left"
    assert lines[-1] == "study depth, 100 of 100 runs: done"
    assert len(lines) == 2 + 19
    assert sum("done" in line for line in lines) == 2


def test_jobs_that_end_at_once_are_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.shown() as told:
        for stage in ("track", "track", "tables"):
            told(stage, 1.0)
    assert capsys.readouterr().err.splitlines() == ["track: done", "tables: done"]


def test_a_terminal_has_one_bar_that_is_read_without_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.StringIO()
    console = Terminal(file=written, force_terminal=True, no_color=True, width=80)
    monkeypatch.setattr(progress, "terminal", lambda **_: console)
    with progress.shown() as told:
        told("wheelset modes, n = 6", 6 / 7)
        told("wheelset poles", 1.0)
        told("study depth, 46 of 183 runs", 46 / 183)
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "\r", written.getvalue())
    last = [line for line in plain.replace("\r", "\n").splitlines() if "[" in line][-1]
    assert last.startswith("study depth, 46 of 183 runs [#####...............]  25 %")
    assert last.rstrip().endswith("left")


def test_durations() -> None:
    assert [progress.duration(each) for each in (0.4, 61, 3661)] == ["0:00", "1:01", "1:01:01"]
