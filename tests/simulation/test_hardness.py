"""Runs with a hardness: the same bits in any blocks, repeated by changes, and those of an elastic run below it."""

import dataclasses
import json

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin import resimulate

FLAT = "irregularities=[{type: flat, on: wheel_1, length: 0.03}]"
ROUGH = "irregularities=[{type: flat, on: wheel_1, length: 0.03}, {type: roughness, on: rail_1, seed: 1}]"
TURN = 2713


def simulator(hardness: float | None, shape: str = FLAT, settle_on: str = "smooth") -> Simulator:
    scenario = toy_scenario(
        shape, f"settle_on={settle_on}", f"contact.hardness={'null' if hardness is None else hardness}"
    )
    bound = scenario.contact.largest_pressure
    return Simulator(scenario, models=dataclasses.replace(toy_models(), hardness=bound, tables="smooth", _smooth=None))


def forces(run: Simulator, steps: int, block: int) -> np.ndarray:
    """The next ``steps`` forces in blocks."""
    blocks = []
    while steps > 0:
        blocks.append(run.advance(min(block, steps)).forces)
        steps -= len(blocks[-1])
    return np.concatenate(blocks)


@pytest.mark.parametrize("shape", [FLAT, pytest.param(ROUGH, marks=pytest.mark.slow)])
def test_the_length_of_blocks_does_not_change_a_bit(shape):
    whole, parts = (simulator(2.6e9, shape, "surfaces") for _ in range(2))
    assert (forces(whole, 2000, 2000) == forces(parts, 2000, 7)).all()


def test_up_to_the_first_yield_a_run_has_the_bits_of_an_elastic_one():
    bounded, elastic = (forces(simulator(each), 2000, 2000) for each in (2.6e9, None))
    first = int((bounded != elastic).any(axis=1).argmax())
    assert 1750 < first < 1850
    assert 0.9 < bounded[:, 0].max() / elastic[:, 0].max() < 1.0


def test_below_yield_a_run_has_the_bits_of_an_elastic_one():
    assert (forces(simulator(2e10), 2000, 500) == forces(simulator(None), 2000, 500)).all()


def test_pressures_of_a_run_are_bounded():
    run = simulator(2.6e9)
    block = run.advance(2000)
    row = int(block.forces[:, 0].argmax())
    patch = run.contact_patch(0, row)
    assert patch.pressure.max() == 2.6e9
    assert patch.force == pytest.approx(block.forces[row, 0], rel=1e-9)
    assert patch.flag.startswith("pressure at the bound of 2.6 GPa on ")
    assert patch.share_at_hardness > 0.2
    kept = run.contact(0, row)
    run.advance(100)
    assert (kept.solve().pressure == patch.pressure).all()


def test_surfaces_that_fade_are_bounded_too():
    models = dataclasses.replace(toy_models(), hardness=2.6e9)
    law, _ = models.fade_law(toy_scenario(), toy_scenario(FLAT), 1000)
    assert law.hardness == 2.6e9


def test_the_hardness_cannot_change_during_a_run():
    run = simulator(2.6e9)
    with pytest.raises(InputError, match="contact cannot change during a run"):
        run.apply(toy_scenario(FLAT, "contact.hardness=3e9"))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            "2.6",
            r"contact.hardness = 2.6 Pa is out of range: give the hardness of .* from 1e\+09 to 2e\+10 Pa",
        ),
        ("hard", "contact.hardness = 'hard' is not a number"),
        ("-1", "contact.hardness = -1 Pa is out of range"),
    ],
)
def test_a_hardness_that_is_none_is_rejected(given, message):
    with pytest.raises(InputError, match=message):
        load_scenario("undamaged", [f"contact.hardness={given}"])


def test_contact_may_be_null_and_is_written_back():
    scenario = load_scenario("undamaged", ["contact.hardness=2.6e9"])
    assert scenario.contact.hardness == 2.6e9
    assert scenario.to_mapping()["contact"] == {"hardness": 2.6e9, "tolerance": 0.001, "exact": False}
    assert load_scenario("undamaged").to_mapping()["contact"]["hardness"] is None


@pytest.mark.slow
def test_a_recorded_run_is_simulated_again_bit_for_bit(tmp_path):
    run = Simulator(load_scenario("flat_fresh", ["contact.hardness=2.6e9"]))
    with record(tmp_path / "run.mcap", run) as push:
        block = run.advance(TURN)
        push(block, summarise(block))
    again = resimulate(tmp_path / "run.mcap")
    assert again.identical
    elastic = resimulate(tmp_path / "run.mcap", ["contact.hardness=null"])
    assert elastic.after.wheels[0].max_force > 1.01 * again.after.wheels[0].max_force


@pytest.mark.slow
def test_a_run_says_where_pressures_are_above_what_steel_bears(capsys):
    assert main(["run", "flat_fresh", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["pressures"]
    assert 6e9 < found["wheel_1"]["largest_Pa"] < 7e9
    assert found["wheel_1"]["hardness_Pa"] == 2.6e9
    assert 0.5 < found["wheel_1"]["share_at_hardness"] < 0.6
    assert found["wheel_1"]["flag"] == "pressure above 2.6 GPa on 56 % of the force"
    assert found["wheel_2"]["flag"] == ""
    assert main(["run", "flat_fresh"]) == 0
    printed = capsys.readouterr().out
    assert "contact pressure wheel_1" in printed
    assert "above 2.6 GPa on 56 % of the force" in " ".join(printed.split())
    assert main(["run", "undamaged", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["pressures"] == {}
