import pytest

from wheelset_track_sim.cli import main
from wheelset_track_sim.cli.map import axis_of, study_of
from wheelset_track_sim.errors import InputError

DEPTH = "irregularities.0.h"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        (f"{DEPTH}=0..3mm", [0.0, 0.0015, 0.003]),
        (f"{DEPTH} = 0.5 mm .. 0.001", [5e-4, 7.5e-4, 1e-3]),
        ("speed=36..72km/h", [10.0, 15.0, 20.0]),
        ("speed=10..20", [10.0, 15.0, 20.0]),
        ("lateral_offset=-5..5mm", [-0.005, 0.0, 0.005]),
    ],
)
def test_ranges(text, values):
    assert axis_of(text, 3, "--x")[1] == {"values": pytest.approx(values)}


def test_distributions():
    assert axis_of("speed=normal(80, 8 km/h)", 3, "--x") == (
        "speed",
        {"distribution": "normal", "mean": "80 km/h", "deviation": "8 km/h"},
    )


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("speed", "--x speed is not an axis: give KEY=LOW..HIGH"),
        ("speed=20", "--x speed=20 is not an axis"),
        ("speed=20..10", "--x speed=20..10 has no range: give the lower end first"),
        ("speed=20..30kN", "--x speed = '20 kN' is not in a unit of this quantity"),
        ("speed=gauss(1, 2)", r"--x speed=gauss\(1, 2\) is not a known distribution"),
        ("speed=normal(1)", r"--x speed=normal\(1\) has 1 parameters: give normal\(mean, deviation\)"),
    ],
)
def test_refused_axes(text, reason):
    with pytest.raises(InputError, match=f"^{reason}"):
        axis_of(text, 3, "--x")


AXES = ("speed=40..80km/h", f"{DEPTH}=0..2mm")


@pytest.mark.parametrize(
    ("axes", "points", "quantity", "limits", "reason"),
    [
        (AXES, "1", "max_force", [], "--points 1 is out of range: give 2 to 200"),
        (AXES, "3x4x5", "max_force", [], "--points 3x4x5 is out of range"),
        (AXES, "3", "force", [], "--quantity force is not a known output"),
        (AXES, "3", "max_force", ["350 mm"], "drawings.0.limits.0 = '350 mm' is not in a unit"),
        ((AXES[0], AXES[0]), "3", "max_force", [], "--y speed=40..80km/h varies what --x does"),
    ],
)
def test_refusals(axes, points, quantity, limits, reason):
    with pytest.raises(InputError, match=f"^{reason}"):
        study_of("damage_wheel_1", axes, points, quantity, limits, {})


def test_the_end_of_an_output_names_it():
    study = study_of("damage_wheel_1", AXES, "4x3", "A1.max_principal", ["90 MPa"], {})
    assert study.outputs == ("nodes.A1.max_principal",)
    assert [len(axis.points) for axis in study.axes] == [4, 3]


@pytest.mark.slow
def test_one_line_draws_a_map(tmp_path, capsys):
    out = tmp_path / "here"
    axes = ("--x", "speed=90..100km/h", "--y", f"{DEPTH}=0..0.3mm")
    assert main(["map", "damage_wheel_1", *axes, "--points", "2", "--workers", "1", "--out", str(out)]) == 0
    assert (out / "map.png").stat().st_size > 10_000
    assert len((out / "results.csv").read_text().splitlines()) == 5
    assert f"picture {out / 'map.png'}" in capsys.readouterr().out.replace("\n", "")
