"""Work in the background: peaks over places, and damage of the axle, in slices that can be stopped."""

import dataclasses
import re

import numpy as np
import pytest

pytest.importorskip("bokeh", reason="the page needs the extra explore")

from support.exploring import toy_explorer
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.explore import background
from wheelset_track_sim.explore.background import CELLS, PLACES, beside, fatigue, heat_map, scatter, values_of
from wheelset_track_sim.explore.messages import judged
from wheelset_track_sim.explore.worker import SupersededError
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin.measured import read_measurement

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def explorer():
    return toy_explorer()


@pytest.fixture(scope="module")
def answer(explorer):
    return explorer.answer(dataclasses.replace(explorer.base.begin, kind="flat", flat=0.03))


def test_the_scatter_is_that_of_answers_at_places_of_the_bay(explorer, answer):
    found = [*scatter(explorer, answer)]
    assert [each["done"] for each in found] == [*range(1, PLACES + 1)]
    places = [dataclasses.replace(answer.view, place=0.6 * number / PLACES) for number in range(PLACES)]
    peaks = [explorer.answer(view).block.forces[:, 0].max() / 1e3 for view in places]
    words = found[-1]["words"]
    assert f"peak {min(peaks):.0f} to {max(peaks):.0f} kN" in words
    assert words.endswith("; above 350 kN at 0 of 12 places.")
    assert "11 to come" in found[0]["words"]


def test_without_a_place_there_is_no_scatter(explorer):
    answer = explorer.answer(dataclasses.replace(explorer.base.begin, kind="none"))
    assert [each["words"] for each in scatter(explorer, answer)] == [""]


def test_the_damage_of_the_axle_is_that_of_the_fatigue_package(explorer, answer, monkeypatch):
    monkeypatch.setattr(background, "DISTANCE", 30.0)
    found = [each for each in fatigue(explorer, answer, lambda stage, share: None) if each]
    scenario = explorer.base.scenario_of(answer.view)
    models = explorer.tabled(scenario)
    static = static_stress(scenario, models.reduced, scenario.output.stress_nodes)
    count = AxleFatigue(static, TurningWheel.of(scenario), load_curve("assumed_body"))
    run = Simulator(scenario, models=models)
    count.push(run.advance(30_000))
    worst = max(count.nodes, key=lambda node: node.ratios[0])
    assert found[-1]["ratio"] == worst.ratios[0]
    assert worst.ratios[0] > 1
    assert f"{worst.ratios[0]:.2f} times that without damage, at {worst.name}" in found[-1]["words"]
    assert "assumed: limit of EA1N" in found[-1]["source"]


def test_what_progress_raises_ends_the_work(explorer, answer):
    def stop(stage, share):
        raise SupersededError

    view = dataclasses.replace(answer.view, flat=0.0313)  # its tables are not there
    with pytest.raises(SupersededError):
        next(fatigue(explorer, explorer.answer(view), stop))


def test_a_map_has_the_answers_at_its_cells(explorer):
    view = dataclasses.replace(explorer.base.begin, kind="flat", flat=0.03)
    coarse = [each for each, _ in zip(heat_map(explorer, view, "place", "load", "force"), range(9), strict=False)]
    assert [each["cell"] for each in coarse] == [[row, column] for row in (0, 4, 8) for column in (0, 4, 8)]
    places, loads = values_of("place"), values_of("load")
    assert (len(places), places[0], places[-1], loads[0]) == (CELLS, 0.0, 0.65, pytest.approx(3e3 * 9.81))
    for each in coarse[:2]:
        row, column = each["cell"]
        answer = explorer.answer(dataclasses.replace(view, place=places[column], load=loads[row]))
        assert each["value"] == answer.block.forces[:, 0].max() / 1e3
    assert (coarse[8]["done"], coarse[8]["of"]) == (9, CELLS**2)


@pytest.mark.parametrize(
    ("sides", "words"),
    [
        (("speed", "depth", "force"), "map y = 'depth' is not a known slider of this view"),
        (("speed", "speed", "force"), "speed on both sides"),
        (("speed", "flat", "noise"), "'noise' is not a known quantity of maps"),
    ],
)
def test_a_map_of_what_is_not_there_is_refused(explorer, sides, words):
    view = dataclasses.replace(explorer.base.begin, kind="flat")
    with pytest.raises(InputError, match=words):
        next(heat_map(explorer, view, *sides))


@pytest.mark.parametrize("axis", ["time [s]", "position [m]"])
def test_a_measurement_is_put_beside_the_answer(answer, tmp_path, axis):
    block = answer.block
    step = block.step_period if axis.startswith("time") else answer.scenario.step_length
    rows = [f"{7.0 + n * step!r},{force / 1e3!r}" for n, force in enumerate((1.1 * block.forces[:, 0]).tolist())]
    (tmp_path / "wayside.csv").write_text("\n".join([f"{axis},wheel_1 [kN]", *rows]))
    header, arrays = beside(answer, read_measurement(tmp_path / "wayside.csv"), "wayside.csv")
    assert header["words"].startswith("wayside.csv, beside the answer: wheel_1: at most ")
    assert "gain 1.100, correlation 1.000" in header["words"]
    peak = int(np.argmax(arrays["force"]))
    assert arrays["force"][peak] == pytest.approx(1.1 * block.forces[:, 0].max() / 1e3, rel=1e-3)
    assert arrays["place"][peak] == pytest.approx(answer.position[answer.peak_row], abs=0.0015)


@pytest.mark.parametrize(("limits", "marks"), [("trafikverket", [200, 350]), ("fra", [200, 356, 400]), ("none", [200])])
def test_verdicts_and_marks_are_those_of_the_limits(explorer, answer, limits, marks):
    found = judged(dataclasses.replace(answer, view=dataclasses.replace(answer.view, limits=limits)))
    assert [round(force) for force, _ in found["marks"]] == marks
    assert bool(found["verdicts"]) == bool(found["sources"]) == (limits != "none")
    assert all(re.search(r"\((trafikverket|fra)\)$", each["words"]) for each in found["verdicts"])
    assert {each["level"] for each in found["verdicts"]} <= {"ok"}


def test_a_long_flat_is_an_alarm(explorer):
    found = judged(explorer.answer(dataclasses.replace(explorer.base.begin, kind="worn_flat", flat=0.05, worn=0.1)))
    assert [each["words"] for each in found["verdicts"] if each["level"] == "alarm"] == [
        "wheel 1: length of tread damage 100 mm is above 60 mm: take the vehicle out of the train, whatever its speed "
        "and axle load (trafikverket)"
    ]
