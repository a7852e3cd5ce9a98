"""Studies as they run: results, failures, going on after kill -9."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.cli import main
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.studies.conduct import Resources, conduct
from wheelset_track_sim.studies.evaluate import evaluate, program
from wheelset_track_sim.studies.store import Store
from wheelset_track_sim.studies.study import load_study

TOO_LONG = {"dynamics": "paper", "speed": 5.0}
"""Paper dynamics runs for 11 s at most, which ``FAR`` exceeds at this speed."""
FAR = {"before": 0.1, "after": 60.0}


def files(out: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in (out / "runs").glob("*.npz")}


@pytest.fixture
def conducted(small, study_file, tmp_path):
    study = load_study(study_file(small))
    return study, *conduct("small", study, study.runs(), tmp_path / "out", Resources(workers=1))


@pytest.mark.slow
def test_a_run_is_what_the_simulator_gives_over_the_window(conducted) -> None:
    _, results, there = conducted
    assert there == 0
    assert not results.failures
    assert set(results.found) == {0, 1, 2, 3}
    simulator = Simulator(load_scenario("damage_wheel_1", ["speed=25", "irregularities.0.h=0.0003"]))
    simulator.advance(1700)
    expected = summarise(simulator.advance(201))
    assert results.value(1, "wheels.wheel_1.max_force") == pytest.approx(expected.wheels[0].max_force, rel=1e-6)
    assert results.value(1, "wheels.wheel_1.min_force") == pytest.approx(expected.wheels[0].min_force, rel=1e-6)
    assert results.value(1, "nodes.A1.max_principal") == pytest.approx(expected.nodes[0].max_principal, rel=1e-6)
    assert results.value(0, "wheels.wheel_1.max_force") < 1.1 * 98.1e3 < results.value(1, "wheels.wheel_1.max_force")


@pytest.mark.slow
def test_finished_runs_are_taken_damaged_and_changed_ones_done_again(conducted, small, study_file, tmp_path) -> None:
    study, results, _ = conducted
    out = tmp_path / "out"
    before = files(out)
    again, there = conduct("small", study, study.runs(), out, Resources(workers=1))
    assert there == 4
    assert files(out) == before
    assert [found.values for found in again.found.values()] == [found.values for found in results.found.values()]

    damaged = out / "runs" / f"{study.runs()[2].job.digest()}.npz"
    damaged.write_bytes(damaged.read_bytes()[:100])
    small["vary"]["irregularities.0.h"] = [0.0, 0.0003, 0.0004]
    more = load_study(study_file(small))
    grown, there = conduct("small", more, more.runs(), out, Resources(workers=1))
    assert there == 3
    assert grown.value(3, "wheels.wheel_1.max_force") == results.value(2, "wheels.wheel_1.max_force")
    after = files(out)
    assert len(after) == 6
    assert {name for name in before if after[name] == before[name]} == set(before) - {damaged.name}


def test_histories_and_pressures_are_of_the_same_run(small, study_file) -> None:
    small["histories"] = ["forces", "principal", "displacements", "irregularity"]
    small["pressures"] = ["wheel_1.reference", "wheel_1.max_force", "wheel_2.max_force"]
    job = load_study(study_file(small)).runs()[3].job
    result = evaluate(job, program())
    arrays = result.arrays
    assert arrays["position"] == pytest.approx(np.linspace(1.7, 1.9, 201))
    assert arrays["forces"][:, 0].max() == result.values["wheels.wheel_1.max_force"]
    assert arrays["principal"][:, 0].max() == result.values["nodes.A1.max_principal"]
    assert arrays["displacements"].shape == (201, 2, 2)
    assert arrays["irregularity"][:, 0].min() == pytest.approx(-0.0003)
    assert arrays["position"][arrays["irregularity"][:, 0].argmin()] == pytest.approx(1.8)
    assert not arrays["irregularity"][:, 1].any()
    for name, wheel in (("wheel_1.reference", 0), ("wheel_1.max_force", 0), ("wheel_2.max_force", 1)):
        position, force, _ = arrays[f"{name}.at"]
        row = round((position - 1.7) / 1e-3)
        assert force == pytest.approx(arrays["forces"][row, wheel], rel=1e-6)
        element = np.diff(arrays[f"{name}.x"])[0] * np.diff(arrays[f"{name}.y"])[0]
        assert arrays[f"{name}.pressure"].sum() * element == pytest.approx(force, rel=1e-9)
    assert arrays["wheel_1.reference.at"][0] == pytest.approx(1.8)
    assert arrays["wheel_1.max_force.at"][1] == pytest.approx(arrays["forces"][:, 0].max(), rel=1e-6)


def test_another_program_is_refused(small, study_file) -> None:
    with pytest.raises(Exception, match="another version of the program"):
        evaluate(load_study(study_file(small)).runs()[0].job, "another")


@pytest.mark.slow
def test_a_failing_run_is_told_with_its_place_and_the_others_are_kept(small, study_file, tmp_path, capsys) -> None:
    small["vary"] = {"case": {"good": {}, "too long": TOO_LONG, "smooth": {"irregularities": []}}}
    small["window"] = FAR
    small["drawings"] = [
        {"type": "lines", "name": "a", "title": "A", "x": "case", "panels": [{"y": ["wheels.wheel_1.max_force"]}]}
    ]
    out = tmp_path / "out"
    assert main(["study", study_file(small), "--out", str(out), "--workers", "2"]) == 1
    told = capsys.readouterr()
    assert "1 run failed" in told.err
    assert "too long" in told.out
    assert len(files(out)) == 2
    summary = (out / "summary.md").read_text()
    assert "## Runs that failed" in summary
    assert "| too long |" in summary
    assert (out / "a.png").exists()
    rows = (out / "results.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows[1:]] == ["good", "too long", "smooth"]
    assert [row.split(",")[2] == "nan" for row in rows[1:]] == [False, True, False]


@pytest.mark.slow
def test_a_study_stopped_by_kill_9_goes_on_where_it_was(small, study_file, tmp_path) -> None:
    small["vary"]["irregularities.0.h"] = [0.0, 0.0001, 0.0002, 0.0003]
    small["window"]["after"] = 30.0
    path, out = study_file(small), tmp_path / "out"
    command = [sys.executable, "-m", "wheelset_track_sim", "study", path, "--out", str(out), "--workers", "1"]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    first = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    deadline = time.monotonic() + 120
    while len(files(out)) < 2:
        assert first.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.005)
    children = Path(f"/proc/{first.pid}/task/{first.pid}/children").read_text().split()
    first.send_signal(signal.SIGKILL)
    first.wait()
    before = files(out)
    assert 2 <= len(before) < 8
    assert not (out / "results.csv").exists()
    for key in before:
        assert Store(out / "runs").load(key.removesuffix(".npz")) is not None
    while any(alive(child) for child in children):  # the workers end too
        assert time.monotonic() < deadline
        time.sleep(0.05)

    second = subprocess.run(command, capture_output=True, text=True, env=environment, check=True, timeout=240)
    assert f"{len(before)} of 8 runs were there already" in second.stdout
    after = files(out)
    assert len(after) == 8
    assert {name: after[name] for name in before} == before
    assert not list((out / "runs").glob("*.tmp"))
    assert len((out / "results.csv").read_text().splitlines()) == 9


def alive(process: str) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["deph"], "'deph' is not a known study: did you mean depth?"),
        (["depth", "--set", "sped=30"], "sped is not a known key: did you mean speed?"),
        (["depth", "--set", "speed=-1"], "speed = -1 m/s is out of range"),
        (["depth", "--dynamics", "casual"], "is not a known choice: did you mean causal?"),
        (["depth", "--workers", "0"], "--workers 0 is out of range"),
        (["depth", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "a --scheduler has its own workers"),
    ],
)
def test_the_command_refuses_before_anything_runs(arguments, said: str, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["study", *arguments]) == 2
    told = capsys.readouterr()
    assert said in told.err
    assert told.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_is_refused(small, study_file, tmp_path, capsys) -> None:
    (tmp_path / "out").write_text("in the way")
    assert main(["study", study_file(small), "--out", str(tmp_path / "out")]) == 2
    assert "cannot be written" in capsys.readouterr().err
