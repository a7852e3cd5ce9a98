import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from wheelset_track_sim.bags import Bag, read_bag
from wheelset_track_sim.cli import main


def test_run_prints_one_json_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "damage_wheel_1", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["steps"] == 2713
    assert result["simulated_s"] == pytest.approx(2.713 / 27.7777778)
    assert result["real_time_factor"] == pytest.approx(result["simulated_s"] / result["wall_s"])
    assert result["scenario"] == "damage_wheel_1"
    assert len(result["digest"]) == 32
    assert (result["speed_m_s"], result["axle_load_N"]) == (27.7777778, 196200.0)
    assert (result["wheelset"], result["track"]) == ("x40", "ballasted_60e1")
    assert set(result["wheels"]) == {"wheel_1", "wheel_2"}
    assert set(result["wheels"]["wheel_1"]) == {"max_force_N", "min_force_N", "contact_loss_s"}
    assert set(result["nodes"]) == {"A1", "B1", "C1"}
    # the figures that the issue of this scenario bounds
    assert 280e3 < result["wheels"]["wheel_1"]["max_force_N"] < 305e3
    assert result["wheels"]["wheel_1"]["min_force_N"] == 0
    assert result["wheels"]["wheel_1"]["contact_loss_s"] > 0
    assert result["nodes"]["A1"]["max_principal_Pa"] == pytest.approx(93.7e6, rel=0.05)


def test_what_events_ask_of_a_node_is_left_out_with_a_warning(capsys: pytest.CaptureFixture[str]) -> None:
    events = "events=[{step: 100, axle_load: 18 t, record: start}, {step: 200, snapshot: true}]"
    assert main(["run", "undamaged", "--duration", "0.01", "--set", events, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["warnings"]
    assert told == [
        f"events.{key} is for the node, and does nothing here: --out records the whole run"
        for key in ("0.record", "1.snapshot")
    ]


def test_smooth_wheels_run_near_102_kn_and_the_statics(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "undamaged", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    for wheel in result["wheels"].values():
        assert wheel["max_force_N"] == pytest.approx(102e3, rel=0.01)
        assert wheel["contact_loss_s"] == 0
    for node, static in (("A1", 66e6), ("B1", 63e6), ("C1", 60e6)):
        assert result["nodes"][node]["min_principal_Pa"] < 1.02 * static
        assert result["nodes"][node]["max_principal_Pa"] > 0.98 * static


def test_run_is_judged_by_a_set_of_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "own.yaml"
    stated = "level: warning, action: inspect, source: a drawing"
    axle = f"{{above: 60 MPa, {stated}, zone: body, grade: EA1N, nodes: [A1]}}"
    path.write_text(f"name: mine\nforce: [{{above: 1 MN, {stated}}}]\naxle: [{axle}]\n")
    arguments = ["run", "undamaged", "--duration", "0.11", "--limits", str(path)]
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["verdict"]
    assert (found["limits"], found["level"]) == ("mine", "warning")
    *_, of_axle = found["comparisons"]
    assert of_axle["compared"] == "bending_amplitude"
    assert of_axle["value_Pa"] == pytest.approx(65.3e6, rel=0.02)  # not the largest principal stress
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    assert "verdict" in printed
    assert "A1: bending amplitude" in printed
    assert main(["run", "undamaged", "--duration", "0.01", "--limits", "none", "--json"]) == 0
    assert "verdict" not in json.loads(capsys.readouterr().out)


def test_run_writes_a_bag_that_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "run.mcap"
    arguments = ["run", "damage_wheel_1", "--duration", "0.12", "--set", "speed=30", "--out", str(bag)]
    assert main([*arguments, "--fatigue", "assumed_body"]) == 0
    printed = capsys.readouterr().out
    assert "108 km/h, 196.2 kN axle load (20 t), x40 on ballasted_60e1" in printed
    assert "contact force wheel_1" in printed
    assert max(map(len, printed.splitlines())) <= 80
    recording = read_bag(bag)
    assert len(recording) == 3600
    assert np.all(np.diff(recording.steps) == 1)
    (fatigue,) = Bag(bag).reader.messages(("Fatigue",), lambda message: message)
    assert (fatigue.next_step, fatigue.curve) == (3600, "assumed_body")
    assert main(["report", str(bag), "--out", str(tmp_path / "page.html")]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"run.mcap", "page.html", "page.png"}
    assert main(["run", "undamaged", "--out", str(bag)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert len(read_bag(bag)) == 3600


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "damage_whel_1"], "did you mean damage_wheel_1"),
        (["run", "undamaged", "--set", "speed=-1"], "from 5 to 100 m/s"),
        (["run", "undamaged", "--limits", "fr"], "did you mean fra"),
        (["run", "undamaged", "--fatigue", "assumed_body"], "--fatigue applies to a recording"),
        (["run", "undamaged", "--set", "spede=30"], "did you mean speed"),
        (["run", "undamaged", "--set", "wheelset=x41"], "x40"),
        (["run", "undamaged", "--set", "track=nowhere"], "ballasted_60e1"),
        (["run", "undamaged", "--set", "output.stress_nodes=[Z1]"], "A1"),
        (["run", "undamaged", "--set", "step_length=0.0007"], "does not divide"),
        (["run", "undamaged", "--dynamics", "quick"], "causal, paper"),
        (["run", "undamaged", "--duration", "nan"], "--duration"),
        (["run", "undamaged", "--duration", "-1"], "--duration"),
        (["run", "undamaged", "--duration", "soon"], "--duration = 'soon' is not a number: give one, alone or with"),
        (["run", "undamaged", "--duration", "10 m"], "--duration = '10 m' is not in a unit of this quantity"),
        (["report", "run.mcap", "--threshold", "25 t/s"], "or with one of N, kN, t, kg, MN"),
        (["run", "undamaged", "--out", "/proc/nowhere/run.mcap"], "cannot be written"),
        (["walk"], "invalid choice"),
        ([], "COMMAND"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = [line for line in printed.err.splitlines() if not line.endswith(": done")]  # progress of models
    assert len(lines) == 1
    assert lines[0].startswith("wheelset-track-sim: ")
    assert words in lines[0]


@pytest.mark.parametrize("bag", ["none.mcap", "."])
def test_a_missing_bag_is_bad_input_in_one_line(
    bag: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments in (["report"], ["info"], ["recover"], ["resimulate"]):
        assert main([*arguments, bag]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.endswith("give a bag folder or an .mcap file")
    assert list(tmp_path.iterdir()) == []


def test_every_command_says_what_it_does(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    commands = re.findall(r"^    (\w+) +(\w.{7})", capsys.readouterr().out, re.MULTILINE)
    assert len(commands) == 26
    for name, words in commands:
        with pytest.raises(SystemExit):
            main([name, "--help"])
        assert words.lower() in capsys.readouterr().out.lower()


INTERRUPTIBLE = """
import signal, sys
from wheelset_track_sim.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job of a shell ignores it
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_an_interrupted_run_leaves_a_readable_bag(tmp_path: Path) -> None:
    bag = tmp_path / "long.mcap"
    arguments = ["run", "undamaged", "--duration", "5000", "--out", str(bag)]
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTIBLE, *arguments], stderr=subprocess.PIPE, text=True)
    try:
        while not bag.exists() or bag.stat().st_size < 2e6:
            assert process.poll() is None
            os.sched_yield()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 1
    assert "interrupted" in errors.splitlines()[-1]
    assert len(read_bag(bag)) > 1000


def test_run_writes_tables_by_the_suffix(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, bag = tmp_path / "run.csv", tmp_path / "run"
    for out in (table, bag):
        assert main(["run", "undamaged", "--duration", "0.01", "--json", "--out", str(out)]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run", "run.csv"]
    assert json.loads(capsys.readouterr().out.splitlines()[0])["steps"] == 278
    heading, *rows = table.read_text(encoding="utf-8").splitlines()
    assert heading.startswith("time [s],step,position [m]")
    assert len(rows) == len(read_bag(bag)) == 278
    assert float(rows[-1].split(",")[5]) == read_bag(bag).forces[-1, 0]
    for arguments, words in (
        (["--out", str(tmp_path / "result.txt")], "ends in .txt, which is not a supported format"),
        (["--out", str(table)], "run.csv exists already"),
        (["--out", str(tmp_path / "new.csv"), "--snapshots", "1"], "new.csv is a table, and you gave options of bags"),
        (["--out", "/proc/run.csv"], "/proc/run.csv cannot be written"),
    ):
        assert main(["run", "undamaged", *arguments]) == 2
        assert words in capsys.readouterr().err.splitlines()[-1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run", "run.csv"]
