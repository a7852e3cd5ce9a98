"""Maps: axes of values and of distributions, drawn, tabled and as arrays; results are made up, nothing is simulated."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.schema import read
from wheelset_track_sim.studies.evaluate import Result
from wheelset_track_sim.studies.results import Results
from wheelset_track_sim.studies.study import Study
from wheelset_track_sim.studies.tables import tables

FORCE = "wheels.wheel_1.max_force"
DEPTH = "irregularities.0.h"
MAP = {"type": "map", "name": "map", "title": "Force", "x": "speed", "y": DEPTH, "output": FORCE, "limits": ["250 kN"]}
LINES = {"type": "lines", "name": "lines", "title": "Force", "x": "speed", "panels": [{"y": [FORCE]}]}
GRID = {
    "title": "Two axes",
    "vary": {"speed": ["40 km/h", "80 km/h", "120 km/h"], DEPTH: ["0.5 mm", "1 mm"]},
    "outputs": [FORCE],
    "drawings": [MAP],
}
DRAWN = GRID | {
    "vary": {
        "speed": {"distribution": "normal", "mean": "80 km/h", "deviation": "8 km/h"},
        DEPTH: {"distribution": "uniform", "low": 0.0, "high": "2 mm"},
    },
    "sampling": {"count": 16},
}


def results_of(content, force=lambda run: 1e4 * run.scenario.speed, failed=()):
    study = read(Study, content, "")
    runs = study.runs()
    found = {n: Result({FORCE: force(run)}, {}) for n, run in enumerate(runs) if n not in failed}
    return Results("made_up", study, runs, found, dict.fromkeys(failed, "made up"))


@pytest.mark.slow
def test_a_map_of_values(tmp_path):
    results = results_of(GRID, failed=(1,))
    (drawing,) = results.study.drawings
    assert [path.suffix for path in drawing.draw(results, tmp_path)] == [".png", ".svg", ".pdf"]
    picture = (tmp_path / "map.svg").read_text()
    assert "250 kN" in picture
    assert "running speed (km/h)" in picture


def test_draws_of_two_axes_belong_together():
    runs = results_of(DRAWN).runs
    assert len(runs) == 16
    assert len({run.scenario.speed for run in runs}) == len({run.scenario.irregularities[0].h for run in runs}) == 16


def test_a_grid_axis_has_all_draws_at_each_value():
    results = results_of(DRAWN | {"vary": DRAWN["vary"] | {"axle_load": [180e3, 200e3]}, "drawings": []})
    assert len(results.runs) == 2 * 16
    table, *_ = tables(results)
    assert [row[0] for row in table.rows] == ["180 kN", "200 kN"]


@pytest.mark.slow
def test_a_map_of_draws_says_how_many_are_above_a_limit(tmp_path):
    results = results_of(DRAWN, lambda run: 2e5 if run.scenario.speed < 80 / 3.6 else 3e5)
    (drawing,) = results.study.drawings
    drawing.draw(results, tmp_path)
    assert "16 draws" in (tmp_path / "map.svg").read_text()
    table, *_ = tables(results)
    assert table.rows == (
        ("contact force wheel 1, max (kN)", "250.0", "51.6", "200.0", "250.0", "300.0", "50 % above 250 kN"),
    )


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"x": "axle_load"}, "drawings.0.x = 'axle_load' is not a known axis of the study"),
        ({"y": "speed"}, "drawings.0.y = 'speed' is x: give another axis"),
        ({"output": "nodes.A1.max_principal"}, "drawings.0.output = 'nodes.A1.max_principal' is not a known output"),
        ({"limits": ["250 mm"]}, "drawings.0.limits.0 = '250 mm' is not in a unit of this quantity"),
        ({"at": {"speed": 3}}, "drawings.0.at.speed is not a known axis of values that is neither x nor y"),
    ],
)
def test_a_map_is_checked(change, reason):
    with pytest.raises(InputError, match=f"^{reason}"):
        read(Study, GRID | {"drawings": [MAP | change]}, "")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (GRID | {"sampling": {"count": 8}}, "sampling draws from distributions, and vary has none"),
        (
            DRAWN | {"sampling": {"method": "saltelli"}, "vary": {"speed": DRAWN["vary"]["speed"]}, "drawings": []},
            "sampling.method = saltelli compares distributions: give two axes or more",
        ),
        (
            DRAWN | {"vary": DRAWN["vary"] | {"speed": [20.0, 30.0]}},
            "drawings.0 has a distribution along one axis only",
        ),
        (
            GRID | {"vary": GRID["vary"] | {"axle_load": [180e3, 200e3]}},
            "drawings.0.at has no axle_load, which the study varies",
        ),
        (
            DRAWN
            | {"drawings": [{"type": "lines", "name": "n", "title": "t", "x": "speed", "panels": [{"y": [FORCE]}]}]},
            "drawings.0 has lines, which need axes of values",
        ),
        (
            DRAWN | {"drawings": [{"type": "sensitivities", "name": "n", "title": "t", "outputs": [FORCE]}]},
            "drawings.0 needs the design saltelli",
        ),
    ],
)
def test_a_study_with_distributions_is_checked(content, reason):
    with pytest.raises(InputError, match=f"^{reason}"):
        read(Study, content, "")


def test_a_draw_out_of_a_keys_range_is_refused_with_its_place():
    study = read(
        Study, DRAWN | {"vary": {"speed": {"distribution": "normal", "mean": 5, "deviation": 1}}, "drawings": []}, ""
    )
    with pytest.raises(InputError, match=r"speed = .* m/s is out of range: .* \(run speed .* km/h\)"):
        study.runs()


@pytest.mark.slow
def test_arrays_have_axes_and_units():
    pytest.importorskip("xarray", reason="the extra analysis brings xarray")
    from wheelset_track_sim.studies.arrays import dataset

    found = dataset(results_of(GRID))
    assert found[FORCE].dims == ("speed", DEPTH)
    assert found[FORCE].sel({"speed": 80 / 3.6, DEPTH: 0.001}, method="nearest") == pytest.approx(8e5 / 3.6)
    assert (found[FORCE].attrs["units"], found.speed.attrs["units"]) == ("N", "m/s")
    drawn = dataset(results_of(DRAWN, failed=(3,)))
    assert drawn[FORCE].dims == ("draw",)
    assert np.isnan(drawn[FORCE][3])
    assert drawn.speed.dims == ("draw",)


LABELLED = GRID | {
    "vary": {"size": {"small": {DEPTH: 0.0005}, "large": {DEPTH: 0.001}}, "speed": [20.0, 30.0]},
    "drawings": [],
}


def test_netcdf_holds_what_the_arrays_hold(tmp_path):
    xarray = pytest.importorskip("xarray", reason="the extra analysis brings xarray")
    from wheelset_track_sim.studies.arrays import dataset, write_netcdf

    results = results_of(LABELLED)
    with xarray.open_dataset(write_netcdf(results, tmp_path), engine="scipy") as read_again:
        assert read_again[FORCE].equals(dataset(results)[FORCE])


def test_zarr_holds_labels_as_an_attribute(tmp_path):
    xarray = pytest.importorskip("xarray", reason="the extra analysis brings xarray")
    pytest.importorskip("zarr", reason="the extra analysis brings zarr")
    from wheelset_track_sim.studies.arrays import write_zarr

    results = results_of(LABELLED)
    for _ in range(2):  # the second replaces the first
        with xarray.open_zarr(write_zarr(results, tmp_path), consolidated=False) as read_again:
            assert read_again["size"].attrs["labels"] == ["small", "large"]
            assert read_again[FORCE].values.tolist() == [[2e5, 3e5]] * 2


@pytest.mark.slow
def test_ishigamis_function_has_its_sensitivities():
    """Closed form of T. Ishigami and T. Homma, An importance quantification technique in uncertainty analysis, 1990."""
    pytest.importorskip("SALib", reason="the extra sensitivity brings SALib")
    from wheelset_track_sim.studies.sensitivities import indices

    a, b = 7.0, 0.1
    ends = {"distribution": "uniform", "low": 0.0, "high": 2.0}
    study = read(
        Study,
        DRAWN
        | {
            "vary": {DEPTH.replace("h", key): ends | {"low": "1 mm", "high": "3 mm"} for key in "ah"} | {"speed": ends},
            "sampling": {"method": "saltelli", "count": 1024},
            "drawings": [],
        },
        "",
    )
    x = np.pi * (np.array([[point.value for point in axis.points] for axis in study.axes]) * [[1e3], [1e3], [1.0]])
    x -= np.pi * np.array([[2.0], [2.0], [1.0]])
    y = np.sin(x[0]) + a * np.sin(x[1]) ** 2 + b * x[2] ** 4 * np.sin(x[0])
    results = dataclasses.replace(results_of(GRID), study=study, runs=(None,) * y.size)
    results = dataclasses.replace(results, found={n: Result({FORCE: float(v)}, {}) for n, v in enumerate(y)})
    found = indices(results, FORCE)
    parts = np.array([0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8, 0.0])
    together = 8 * b**2 * np.pi**8 / 225
    variance = parts.sum() + together
    assert found.first[:, 0] == pytest.approx(parts / variance, abs=0.03)
    assert found.total[:, 0] == pytest.approx((parts + np.array([together, 0.0, together])) / variance, abs=0.03)


def test_no_sensitivities_where_runs_failed():
    pytest.importorskip("SALib", reason="the extra sensitivity brings SALib")
    from wheelset_track_sim.studies.sensitivities import indices

    study = DRAWN | {"sampling": {"method": "saltelli", "count": 4}}
    assert indices(results_of(study, failed=(2,)), FORCE) is None
    assert indices(results_of(study, lambda run: 1.0), FORCE) is None
    assert indices(results_of(study), FORCE).first.shape == (2, 2)
