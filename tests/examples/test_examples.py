"""Examples that need no ROS: each runs, and one number of it is right."""

import runpy
import sys

import pytest

from support.paths import ROOT

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
    names, _ = run("bag_to_pandas.py", ROOT / "tests" / "data" / "damage_wheel_1_of_0_1.mcap")
    assert names["frame"]["wheel_1"].max() == pytest.approx(275.5e3, rel=1e-3)
    assert "wheel_1,2754" in (tmp_path / "peaks.csv").read_text()


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
