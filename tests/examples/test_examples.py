"""Examples that need no ROS: each runs, and one number of it is right."""

import runpy
import sys

import numpy as np
import pytest

from support.paths import OLD_BAG, ROOT

EXAMPLES = ROOT / "examples"


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    def run(name, *arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        names = runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return names, capsys.readouterr().out

    return run


@pytest.mark.slow
def test_run_and_plot(run, tmp_path):
    _, printed = run("run_and_plot.py")
    assert printed == "largest force 275.5 kN\n"
    assert (tmp_path / "forces.png").stat().st_size > 10_000


@pytest.mark.slow
def test_receptances(run):
    names, _ = run("receptances.py")
    assert names["of_rail"][0].real == pytest.approx(1.144e-8, rel=2e-3)
    assert names["pinned"] == pytest.approx(1073.0, abs=10.0)
    assert names["moving"].direct.shape == (4, 6000)


@pytest.mark.slow
def test_bag_to_pandas(run, tmp_path):
    pytest.importorskip("pandas")
    names, _ = run("bag_to_pandas.py", OLD_BAG)
    assert names["frame"]["wheel_1"].max() == pytest.approx(275.5e3, rel=1e-3)
    assert "wheel_1,2754" in (tmp_path / "peaks.csv").read_text()


@pytest.mark.slow
def test_green_functions(run, tmp_path):
    names, printed = run("green_functions.py")
    assert 1e3 * names["deflection"].max() == pytest.approx(0.399, rel=2e-3)
    assert printed.startswith("above a sleeper: 0.38 mm after 1.1 ms\n")
    assert (tmp_path / "green_functions.npz").stat().st_size > 10_000


def test_bag_to_xarray(run, tmp_path):
    pytest.importorskip("xarray")
    tables = pytest.importorskip("pyarrow.parquet")
    names, printed = run("bag_to_xarray.py", OLD_BAG)
    assert names["highest"] == pytest.approx(88.9, rel=1e-3)
    assert printed.endswith("3000 steps of forces, in N\n")
    forces = tables.read_table(tmp_path / f"{OLD_BAG.stem}.parquet")["wheel_1"].to_numpy()
    assert forces.max() == pytest.approx(275.5e3, rel=1e-3)


@pytest.mark.slow
def test_study_with_dask(run):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as here:
        _, printed = run("study_with_dask.py", here.scheduler_address)
    assert printed == "30 mm: 199 kN, 76.4 MPa\n50 mm: 274 kN, 88.0 MPa\n"


@pytest.mark.slow
def test_baseline_detector(run, tmp_path):
    """On signals that are made up: damaged wheels are louder in a band, so the forest finds all of them."""
    for library in ("xarray", "pyarrow", "sklearn"):
        pytest.importorskip(library, reason=f"{library} is not installed: the extra test brings it")
    pytest.importorskip("zarr", minversion="3", reason="zarr is not installed: the extra analysis brings it")
    import pyarrow
    from pyarrow import parquet

    from wheelset_track_sim.dataset.store import ArrayPlan, ChunkStore

    count, random = 60, np.random.default_rng(1)
    about = {"rate_Hz": 1e4, "channels": ["wheel_1", "wheel_2"]}
    plan = ArrayPlan((count, 2, 500), count, ("sample", "channel", "time"), about)
    store = ChunkStore(tmp_path / "data.zarr", {"axle_box_acceleration": plan}, {})
    store.begin()
    damaged = np.arange(count) % 2 == 0
    signals = random.standard_normal((count, 2, 500)) + damaged[:, None, None] * np.sin(np.arange(500))
    store.save(0, {"axle_box_acceleration": signals.astype(np.float32)})
    store.write_text("card.json", '{"title": "Made up"}')
    labels = {
        "damage": np.where(damaged, "flat", "none"),
        "split": np.where(np.arange(count) < 40, "train", "test"),
        "speed": random.uniform(20, 30, count),
        "axle_load": random.uniform(1e5, 2e5, count),
    }
    parquet.write_table(pyarrow.table(labels), tmp_path / "data.zarr" / "labels.parquet")
    _, printed = run("baseline_detector.py", tmp_path / "data.zarr")
    assert "random forest: area 1.000 over 20 samples of the part test" in printed
    assert (tmp_path / "roc.png").stat().st_size > 10_000


def test_fleet_by_passage(run, tmp_path):
    """With a table that is made up, in which peaks and damage rise with the length of a flat."""
    from wheelset_track_sim.studies.damage_table import DamageTable

    sizes, speeds, loads = np.linspace(0.0, 0.06, 4), np.array([16.0, 34.0]), np.array([98e3, 216e3])
    grown = np.ones((4, 2, 2)) * sizes[:, None, None]
    peaks = np.stack([1e5 + share * 3e6 * grown for share in (0.95, 1.0, 1.05)], axis=-1)
    damage = 1e-9 * np.exp(60.0 * grown)[..., np.newaxis]
    table = DamageTable("irregularities.0.length", sizes, speeds, loads, ("A1",), damage, peaks)
    table.save(tmp_path / "flats.npz")
    _, printed = run("fleet_by_passage.py", "60", "4", "flats.npz")
    assert printed.startswith("240 passages of 60 wheelsets: ")


def test_pair_launches_two_wheelsets(monkeypatch):
    from support.launch_stand_in import install

    install(monkeypatch)
    described = runpy.run_path(str(EXAMPLES / "pair.launch.py"))["generate_launch_description"]()
    nodes = [action.named for action in described.values[0]]
    assert [(node["namespace"], node["name"], node["executable"]) for node in nodes] == [
        ("train", "leading", "node"),
        ("train", "trailing", "node"),
    ]


def test_every_example_is_on_the_page():
    page = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for path in EXAMPLES.iterdir():
        assert path.name == "README.md" or f"[{path.name}]({path.name}" in page or not path.suffix, path.name
