"""Notebooks: their cells run and print what is stored in them, and one number of each is right."""

import json
import math

import pytest

from support.paths import ROOT
from tools.notebooks import FOLDER, executed, printed

RIGHT = {
    "bag": lambda names: (names["run"].forces.max(), 291.2e3),
    "contact": lambda names: (names["turn"].forces[:, 0].max(), 291.2e3),
    "greens_functions": lambda names: (names["deflection"].max(), 0.399e-3),
    "receptances": lambda names: (names["pinned"], 1077.0),
    "study": lambda names: (names["values"]["wheels.wheel_1.max_force"].max(), 290.9e3),
}
"""By notebook, from the names that it defines: a number, and what it has to be."""


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGHT)
def test_a_notebook_runs_and_shows_what_it_prints(name, tmp_path, monkeypatch):
    if name == "bag":
        pytest.importorskip("pandas")
        pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    stored = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    again, names = executed(stored)
    assert printed(again) == printed(stored), "python -m tools.notebooks stores it"
    number, right = RIGHT[name](names)
    assert math.isclose(number, right, rel_tol=2e-3)


def test_all_notebooks_are_small_and_on_the_page():
    page = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    paths = [*FOLDER.glob("*.ipynb")]
    assert {path.stem for path in paths} == {*RIGHT}
    for path in paths:
        assert path.stat().st_size < 300_000
        assert f"(notebooks/{path.name})" in page
