"""docs/howto/bags.md: its examples run, and say what is so."""

import re
import shlex

import numpy as np
import pytest

from support.paths import ROOT
from wheelset_track_sim.cli import main

PAGE = (ROOT / "docs" / "howto" / "bags.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_examples_run(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    assert main(["run", "damage_wheel_1", "--duration", "0.25", "--out", "run", "--json"]) == 0
    for line in re.findall(r"^    \.venv/bin/wheelset-track-sim (.*)$", PAGE, flags=re.MULTILINE):
        assert main(shlex.split(line, comments=True)) == 0, line
    names = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL):
        exec(code, names)
    assert (tmp_path / "run_recovered" / "metadata.yaml").exists()
    part, turn, whole = names["part"], names["turn"], names["run"]
    assert part.time[0] >= 0.06 > part.time[0] - part.step_period[0]
    assert part.nodes == ("A1",)
    assert turn.steps.tolist() == [*range(2713, 5426)]
    assert names["highest"] == whole.forces.max() > 250e3
    assert names["frame"].attrs["units"]["wheel_1"] == names["data"].force.attrs["units"] == "N"
    np.testing.assert_array_equal(names["frame"]["wheel_1"], names["data"].force.sel(wheel="wheel_1"))
    assert names["losses"] == []
