"""``run`` with the options of its bag."""

from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.cli import main

PLAN = """
name: up_and_down
speed: 25.0
acceleration: 10.0
axle_load: 196200.0
speed_plan:
  - {time: 0.2, speed: 26.0}
  - {time: 0.6, speed: 25.5}
"""


@pytest.mark.slow
def test_each_change_of_a_speed_plan_is_in_the_bag_with_its_step(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plan.yaml").write_text(PLAN)
    arguments = ["run", str(tmp_path / "plan.yaml"), "--duration", "1.3", "--out", str(tmp_path / "run")]
    assert main([*arguments, "--split-duration", "1000 ms"]) == 0
    capsys.readouterr()
    assert sorted(file.name for file in (tmp_path / "run").glob("*.mcap")) == ["run_0.mcap", "run_1.mcap"]
    found = read_bag(tmp_path / "run")
    np.testing.assert_array_equal(found.steps, np.arange(len(found)))
    told = {state.speed_set_point: state for state in reversed(found.states)}  # the first of each
    assert [*reversed(told)] == [25.0, 26.0, 25.5]
    for state, time in zip(reversed(told.values()), (0.0, 0.2, 0.6), strict=True):
        assert state.time == pytest.approx(time, abs=0.06)
        assert state.time == found.time[state.first_step]
        assert state.scenario == found.info.scenario
    again = read_bag(tmp_path / "run" / "run_1.mcap").states[0]
    assert (again.first_step, again.speed_set_point) == (int(read_bag(tmp_path / "run" / "run_1.mcap").steps[0]), 25.5)


@pytest.mark.slow
def test_snapshots_of_impacts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["run", "damage_wheel_1", "--duration", "1.5", "--out", str(tmp_path / "run"), "--snapshots", "0.2"]
    assert main(arguments) == 0
    capsys.readouterr()
    snapshots = [*(tmp_path / "run").iterdir()]
    assert len(snapshots) == 2  # the second is open for a second behind its impact, until the run ends
    assert main(["info", str(tmp_path / "run")]) == 2
    assert f"give a bag folder or an .mcap file, such as {min(snapshots)}\n" in capsys.readouterr().err
    for path in snapshots:
        found = read_bag(path)
        step = int(path.name.rpartition("_")[2])
        assert found.forces[step - int(found.steps[0])].max() > 200e3
    assert main([*arguments[:-2], "--out", str(tmp_path / "none"), "--snapshots", "0.2", "--threshold", "4 MN"]) == 0
    assert [*(tmp_path / "none").iterdir()] == []


@pytest.mark.parametrize(
    ("arguments", "refusal"),
    [
        (["--split-size", "10"], "--split-size applies to a recording: give --out as well"),
        (["--threshold", "1e5"], "--threshold applies to a recording: give --out as well"),
        (["--out", "run", "--split-size", "10"], "--split-size = 10 bytes is out of range: give at least 1e+06 bytes"),
        (["--out", "run", "--split-duration", "nan"], "--split-duration = 'nan' is not a number"),
        (["--out", "run", "--snapshots", "1e9"], "--snapshots = 1e+09 s is out of range: give the time before"),
        (["--out", "run.mcap", "--max-total-size", "10000000"], "run.mcap is a single file, which cannot be split"),
        (["--out", "run", "--threshold", "-1"], "threshold = -1 N is out of range"),
    ],
)
def test_bad_bounds_are_refused_by_name(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    refusal: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", "undamaged", *arguments]) == 2
    error = capsys.readouterr().err
    assert refusal in error
    assert error.count("\n") == 1
    assert [*tmp_path.iterdir()] == []
