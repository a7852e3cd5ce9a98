"""``resimulate`` on the command line, and its old name."""

import json
from pathlib import Path

import pytest

from wheelset_track_sim.cli import main


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bag") / "run.mcap"
    assert main(["run", "damage_wheel_1", "--out", str(path), "--json"]) == 0
    return path


def resimulate(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    capsys.readouterr()
    status = main(["resimulate", *map(str, arguments)])
    return status, capsys.readouterr().out


@pytest.mark.slow
def test_a_run_is_told_to_be_bit_identical(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, text = resimulate(capsys, bag)
    assert status == 0
    assert "Bit-identical" in text
    status, text = resimulate(capsys, bag, "--json")
    found = json.loads(text)
    assert (status, found["identical"], found["force"], found["differs_here"]) == (0, True, None, {})
    assert found["recorded"] == found["simulated"]


@pytest.mark.slow
def test_what_would_have_been_stands_beside_what_was(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "shallow.mcap"
    status, text = resimulate(capsys, bag, "--set", "wheel_1.damage.h=0.0003", "--json", "--out", out)
    assert status == 0
    found = json.loads(text)
    forces = [found[which]["wheels"]["wheel_1"]["max_force_N"] for which in ("recorded", "simulated")]
    assert forces[1] < 0.95 * forces[0]
    assert found["force"]["signal"] == "wheel_1"
    assert found["force"]["first"]["position_m"] == pytest.approx(1.765, abs=0.02)
    status, text = resimulate(capsys, out)  # what was written is a run like any other
    assert status == 0
    assert "Bit-identical" in text
    status, text = resimulate(capsys, bag, "--set", "speed=20")
    assert "with speed=20" in text
    assert "Largest difference in force" in text


def test_the_old_name_does_the_same_and_names_the_new_one(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["replay", str(bag), "--simulate-again", "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["identical"]
    assert "replay --simulate-again is the old name of resimulate: use wheelset-track-sim resimulate" in captured.err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["resimulate"], "arguments are required: BAG"),
        (["resimulate", "BAG", "--set", "sped=2"], "did you mean speed"),
        (["resimulate", "BAG", "--rate", "2"], "unrecognized arguments: --rate"),
        (["replay", "BAG", "--simulate-again", "--rate", "2"], "unrecognized arguments: --rate"),
        (["replay", "BAG", "--set", "speed=2"], "unrecognized arguments: --set"),
    ],
)
def test_what_does_not_go_together_is_refused(
    bag: Path, arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(bag) if each == "BAG" else each for each in arguments]) == 2
    assert reason in capsys.readouterr().err
