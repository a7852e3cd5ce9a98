"""Figures, tables and summaries that a study leaves."""

import csv
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from matplotlib import image

from wheelset_track_sim.cli import main

LINES = {
    "type": "lines",
    "name": "over_speed",
    "title": "Forces over the speed",
    "x": "speed",
    "panels": [
        {
            "title": "smooth",
            "y": ["wheels.wheel_1.max_force", "wheels.wheel_1.min_force"],
            "at": {"irregularities.0.h": 0},
        },
        {"title": "stress", "y": ["nodes.A1.max_principal"]},
    ],
}
HISTORIES = {
    "type": "histories",
    "name": "passage",
    "title": "Forces along the track",
    "before": 0.05,
    "panels": [{"of": "forces", "columns": ["wheel_1", "wheel_2"], "mark": ["max"]}],
}
MAPS = {"type": "pressure_maps", "name": "patches", "title": "Contact pressure"}


@pytest.fixture
def left(small, study_file, tmp_path, capsys):
    """Folder of a study with every kind of drawing."""
    small |= {"drawings": [LINES, HISTORIES, MAPS], "histories": ["forces"], "pressures": ["wheel_1.max_force"]}
    small["description"] = "Told <once>."
    out = tmp_path / "out"
    assert main(["study", study_file(small), "--out", str(out), "--workers", "1"]) == 0
    assert "summary" in capsys.readouterr().out
    return out


def texts(path):
    return " ".join(ET.parse(path).getroot().itertext())


@pytest.mark.slow
def test_a_study_leaves_figures_tables_and_summaries(left) -> None:
    for name in ("over_speed", "passage", "patches"):
        assert image.imread(left / f"{name}.png").shape[1] == 1200
        assert "causal dynamics" in texts(left / f"{name}.svg")
    drawn = texts(left / "over_speed.svg")
    for text in ("running speed (km/h)", "contact force wheel 1 (kN)", "max. principal stress A1, max (MPa)", "paper"):
        assert text in drawn
    assert "contact force (kN)" in texts(left / "passage.svg")
    assert "contact pressure (GPa)" in texts(left / "patches.svg")

    with (left / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["speed (m/s)"]) for row in rows] == pytest.approx([25, 25, 27.7777778, 27.7777778], rel=1e-6)
    assert rows[0]["dynamics"] == "causal"
    forces = [float(row["contact force wheel 1, max (N)"]) for row in rows]
    assert forces[1] > forces[0] > 98e3
    # At 100 km/h without depth it is the paper's first case, and no other run is one of its cases.
    assert [row["paper: contact force wheel 1, max (N)"] for row in rows] == ["nan", "nan", "131000", "nan"]
    with (left / "history_100_km_h_0_3_mm.csv").open() as file:
        history = list(csv.DictReader(file))
    assert max(float(row["wheel_1 contact force (N)"]) for row in history) == pytest.approx(forces[3], rel=1e-6)
    with (left / "pressure_100_km_h_0_3_mm_wheel_1_max_force.csv").open() as file:
        patch = np.loadtxt(file, delimiter=",", skiprows=1)
    element = np.diff(np.unique(patch[:, 0])).min() * np.diff(np.unique(patch[:, 1])).min()
    assert patch[:, 2].sum() * element == pytest.approx(forces[3], rel=1e-5)

    markdown, page = (left / "summary.md").read_text(), (left / "summary.html").read_text()
    for text in ("| 100 km/h | 0 mm |", "| 131.0 kN |", "![over speed](over_speed.png)", "[results.csv](results.csv)"):
        assert text in markdown
    assert "Told &lt;once&gt;." in page
    assert page.count("<svg ") == 3
    for outside in ("src=", "http://localhost", "<script", "<link"):
        assert outside not in page
    identifiers = [part.split('"')[0] for part in page.split(' id="')[1:]]
    assert len(identifiers) == len(set(identifiers))


def test_parquet_without_its_library_is_refused_before_anything_runs(small, study_file, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert main(["study", study_file(small), "--out", str(tmp_path / "out"), "--parquet"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--parquet needs pyarrow, which is not installed" in line
    assert "extra analysis" in line
    assert not (tmp_path / "out").exists()
