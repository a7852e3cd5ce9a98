"""``stress`` on the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.cli import main
from wheelset_track_sim.twin.measured import read_measurement

EXAMPLE = ROOT / "config" / "measured" / "synthetic_wayside.csv"


@pytest.mark.slow
def test_stresses_are_told_and_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "stress.csv"
    assert main(["stress", str(EXAMPLE), "--nodes", "A1,C1", "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["wheelset"], found["samples"], [*found["nodes"]]) == ("x40", 800, ["A1", "C1"])
    written = read_measurement(out)
    assert {"A1", "C1", "A1_yy"} <= written.signals.keys()
    assert written.signals["A1"].max() == found["nodes"]["A1"]["max_principal_Pa"]
    measured = read_measurement(EXAMPLE)
    np.testing.assert_allclose(written.at, measured.at, atol=1e-6)
    # What the file has as strain-derived stress, and what its forces alone make of the axle.
    assert np.corrcoef(written.signals["A1_yy"][200:], measured.signals["A1_yy"][200:])[0, 1] > 0.98


def test_own_weight_takes_its_part(capsys: pytest.CaptureFixture[str]) -> None:
    """Of the X40 at any load 5.1 to 6.9 MPa; an imported wheelset has it by its file."""
    found = []
    for arguments in ([], ["--own-weight"]):
        assert main(["stress", str(EXAMPLE), *arguments, "--json"]) == 0
        nodes = json.loads(capsys.readouterr().out)["nodes"].values()
        found.append(np.array([node["max_principal_Pa"] for node in nodes]))
    assert found[0] - found[1] == pytest.approx([5.14e6, 6.91e6, 5.42e6], rel=0.01)
    assert main(["stress", str(EXAMPLE), "--wheelset", "trailer_calculix", "--own-weight", "--json"]) == 0


def test_a_bag_of_stresses_is_one_like_any_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "stress.mcap"
    assert main(["stress", str(EXAMPLE), "--speed", "27.8", "--out", str(bag)]) == 0
    assert "maximum principal stress A1" in capsys.readouterr().out
    found = read_bag(bag)
    np.testing.assert_allclose(found.forces[:, 0], read_measurement(EXAMPLE).signals["wheel_1"])
    assert found.nodes == ("A1", "B1", "C1")
    assert found.max_principal[:, 0].max() > 70e6


@pytest.mark.parametrize("start", [-0.05, 3.85e9])
def test_a_bag_of_stresses_begins_at_any_time(tmp_path: Path, start: float) -> None:
    """Before a trigger, or in seconds since 1904: stamps hold neither."""
    path, bag = tmp_path / "forces.csv", tmp_path / "stress.mcap"
    rows = "\n".join(f"{start + number / 1024!r},98,97" for number in range(100))
    path.write_text(f"time [s],wheel_1 [kN],wheel_2 [kN]\n{rows}\n")
    assert main(["stress", str(path), "--nodes", "A1", "--speed", "20", "--out", str(bag)]) == 0
    found = read_bag(bag)
    np.testing.assert_allclose(found.time, start + np.arange(100) / 1024, atol=1e-6)
    assert main(["info", str(bag)]) == 0


def test_positions_need_a_speed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "forces.csv"
    rows = "\n".join(f"{number},98,97" for number in range(100))
    path.write_text(f"position [mm],wheel_1 [kN],wheel_2 [kN]\n{rows}\n")
    assert main(["stress", str(path)]) == 2
    assert "holds forces over position: give --speed" in capsys.readouterr().err
    assert main(["stress", str(path), "--speed", "72 km/h", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["step_s"] == pytest.approx(1e-3 / 20)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--nodes", "Z9"], "'Z9' is not a known stress node"),
        (["--wheelset", "x41"], "did you mean x40"),
        (["--speed", "1e9"], "speed = 1e+09 m/s is out of range"),
        (["--out", "stress.txt"], "ends neither in .csv nor in .mcap"),
        (["--out", "stress.mcap"], "holds the position of each sample: give --speed"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", str(EXAMPLE), *arguments]) == 2
    assert reason in capsys.readouterr().err


ROWS = [(number / 1e4, 98.0 + number % 9, 97.0 + number % 7) for number in range(100)]
STATIC = 65.8e6 * 102.0 / 98.1
"""Stress at A1, Pa: that of the static load, in proportion."""


@pytest.mark.parametrize(
    ("heading", "scale", "options"),
    [
        ("time [s],wheel_1 [kN],wheel_2 [kN]", (1.0, 1.0), []),
        ("time [s],wheel_1 [kN],wheel_2 [kN]", (1e3, 1e3), ["--unit", "N"]),
        ("time [s],wheel_1 [kN],wheel_2 [kN]", (-1.0, -1.0), ["--sign", "tension"]),
        ("time [s],left,right", (1.0, 1.0), ["--unit", "kN", "--column", "wheel_1=left", "--column", "wheel_2=right"]),
    ],
)
def test_what_the_file_does_not_say_is_an_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], heading: str, scale: tuple[float, float], options: list[str]
) -> None:
    """F7: stresses of GPa, or of none, came without a word; now each file ends with its remedy until it is given."""
    path = tmp_path / "forces.csv"
    path.write_text("\n".join([heading, *(f"{t!r},{scale[0] * a!r},{scale[1] * b!r}" for t, a, b in ROWS)]))
    if options:
        assert main(["stress", str(path), "--json"]) == 2
        told = capsys.readouterr().err
        assert "\n" not in told.strip()
        assert options[0] in told or "write" in told or "has no signal" in told
    assert main(["stress", str(path), "--nodes", "A1", "--json", *options]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["warnings"] == []
    assert found["nodes"]["A1"]["max_principal_Pa"] == pytest.approx(STATIC, rel=0.03)


def test_offsets_are_static_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "forces.csv"
    path.write_text(
        "\n".join(["t [s],wheel_1 [kN],wheel_2 [kN]", *(f"{t!r},{a - 102!r},{b - 100!r}" for t, a, b in ROWS)])
    )
    assert main(["stress", str(path)]) == 2
    assert "static load is missing, as behind an AC-coupled amplifier: give --offset" in capsys.readouterr().err
    assert (
        main(["stress", str(path), "--offset", "100kN", "--offset", "wheel_1 = 102e3", "--nodes", "A1", "--json"]) == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert found["nodes"]["A1"]["max_principal_Pa"] == pytest.approx(STATIC, rel=0.03)
    for wrong in (
        ["--offset", "100 t"],
        ["--offset", "A1=1kN"],
        ["--column", "left"],
        ["--sign", "up"],
        ["--unit", "lb"],
    ):
        assert main(["stress", str(path), *wrong]) == 2


def test_warnings_are_printed_and_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "forces.csv"
    path.write_text("\n".join(["t [s],wheel_1 [kN],wheel_2 [kN]", *(f"{t!r},{a!r},98" for t, a, _ in ROWS)]))
    assert main(["stress", str(path), "--nodes", "A1", "--json"]) == 0
    captured = capsys.readouterr()
    [warning] = json.loads(captured.out)["warnings"]
    assert "wheel_2 is constant at 98 kN" in warning
    assert f"wheelset-track-sim: warning: {warning}\n" in captured.err


def test_forces_of_one_wheel_are_not_enough(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "forces.csv"
    path.write_text("time [s],wheel_1 [kN]\n" + "\n".join(f"{number},98" for number in range(100)))
    assert main(["stress", str(path)]) == 2
    assert "has no wheel_2" in capsys.readouterr().err
