"""What was measured, on the page of a run."""

from pathlib import Path

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.cli import main

EXAMPLE = ROOT / "config" / "measured" / "synthetic_wayside.csv"


@pytest.mark.slow
def test_the_page_shows_both_curves_and_how_well_they_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag, page = tmp_path / "run.mcap", tmp_path / "run.html"
    assert main(["run", "damage_wheel_1", "--duration", "0.15", "--out", str(bag), "--json"]) == 0
    assert main(["report", str(bag), "--measured", str(EXAMPLE), "--lag", "0.04", "--out", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    for word in ("Beside measured: synthetic_wayside.csv", 'id="measures"', "A1_yy", "measured-plots", "correlation"):
        assert word in text
    capsys.readouterr()
    other = str(tmp_path / "other.html")
    assert main(["report", str(bag), "--measured", str(EXAMPLE), "--lag", "9", "--out", other]) == 2
    assert "give another lag" in capsys.readouterr().err


def test_long_records_are_drawn_without_losing_a_peak() -> None:
    from wheelset_track_sim.report.measured import MOST, drawn  # with bokeh

    at = np.arange(300_001.0)
    values = np.zeros((300_001, 2))
    values[-2, 0], values[7, 1] = 5.0, -3.0
    axis, curves = drawn(at, values)
    assert len(axis) == len(curves) <= MOST
    assert (np.diff(axis) > 0).all()
    assert curves[:, 0].max() == 5.0
    assert curves[:, 1].min() == -3.0
    np.testing.assert_array_equal(drawn(at[:100], values[:100])[0], at[:100])
