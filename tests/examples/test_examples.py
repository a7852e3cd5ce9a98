"""Examples that need no ROS: each runs, and one number of it is right."""

import runpy
import sys

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
