"""Runs with the contact filter: the same bits in any blocks, counted, simulated again; without it, those of before."""

import dataclasses
import json

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.cli import main
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.yaml12 import dump, parse
from wheelset_track_sim.live import run_messages
from wheelset_track_sim.live.run_messages import record
from wheelset_track_sim.samples.block import NO_CONTACTS, ContactCounts
from wheelset_track_sim.samples.summary import combine, summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.twin import resimulate

ROUGH = "irregularities=[{type: roughness, on: wheel_1, seed: 1}, {type: flat, on: wheel_2, length: 0.03}]"


def simulator(*settings: str, tables: bool = True) -> Simulator:
    scenario = toy_scenario(ROUGH, "settle_on=surfaces", *settings)
    tolerance = scenario.contact.largest_estimate
    models = dataclasses.replace(
        toy_models(), tolerance=tolerance, hardness=scenario.contact.largest_pressure, tables=tables, _smooth=None
    )
    return Simulator(scenario, models=models)


def blocks(run: Simulator, steps: int, length: int) -> list:
    found = []
    while steps > 0:
        found.append(run.advance(min(length, steps)))
        steps -= len(found[-1])
    return found


def forces(found: list) -> np.ndarray:
    return np.concatenate([block.forces for block in found])


@pytest.mark.slow
def test_the_length_of_blocks_does_not_change_a_bit():
    whole, parts = (blocks(simulator("contact.tolerance=0.0003"), 3500, length) for length in (3500, 7))
    assert (forces(whole) == forces(parts)).all()
    total = combine(summarise(block) for block in parts).contacts
    assert total == combine(summarise(block) for block in whole).contacts
    assert total.filtered_steps > 1000
    assert total.solved_steps > 0


@pytest.mark.slow
def test_exact_runs_are_those_without_a_filter():
    exact, filtered, loose = (
        blocks(simulator(*settings), 2500, 2500)
        for settings in (["contact.exact=true"], [], ["contact.tolerance=0.01"])
    )
    assert sum((block.contacts for block in exact), NO_CONTACTS).filtered_steps == 0
    apart = np.abs(forces(filtered) - forces(exact)).max()
    assert 0.0 < apart < 0.005 * 98.1e3
    counts = [sum((block.contacts for block in run), NO_CONTACTS) for run in (filtered, loose)]
    assert counts[0].largest_estimate <= 0.001 * 98.1e3
    assert counts[1].solved_steps <= counts[0].solved_steps


def test_with_a_hardness_and_without_tables_nothing_is_filtered():
    for run in (simulator("contact.hardness=5e9"), simulator(tables=False), simulator("contact.exact=true")):
        law = run.models.contact_law(run.scenario.irregularities)
        assert law.hinges.element.size == 0
    assert simulator().models.contact_law(simulator().scenario.irregularities).hinges.element.size > 0


def test_counts_add_up():
    assert ContactCounts(1, 2, 3.0) + ContactCounts(10, 20, 1.0) == ContactCounts(11, 22, 3.0)
    assert NO_CONTACTS + ContactCounts(1, 2, 3.0) == ContactCounts(1, 2, 3.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("tolerance=0.5", r"contact.tolerance = 0.5 is out of range: give the largest estimated error .* to 0.01"),
        ("tolerance=0", "contact.tolerance = 0 is out of range"),
        ("exact=1", "contact.exact = 1 is not of type bool: give true or false"),
    ],
)
def test_settings_that_are_none_are_rejected(given, message):
    with pytest.raises(InputError, match=message):
        load_scenario("undamaged", [f"contact.{given}"])


@pytest.mark.slow
def test_a_recorded_run_is_simulated_again_bit_for_bit(tmp_path):
    run = Simulator(load_scenario("polygon"))
    with record(tmp_path / "run.mcap", run) as push:
        for block in blocks(run, 1500, 500):
            push(block)
    assert resimulate(tmp_path / "run.mcap").identical
    assert not resimulate(tmp_path / "run.mcap", ["contact.exact=true"]).identical


@pytest.mark.slow
def test_runs_from_before_the_filter_are_simulated_again_exactly(tmp_path, monkeypatch):
    def without_the_keys(simulator):
        info = made(simulator)
        return dataclasses.replace(info, scenario=older(info.scenario), inputs=tuple(
            found._replace(scenario=older(found.scenario)) for found in info.inputs))  # fmt: skip

    def older(scenario):
        data = parse(scenario, "it")
        return dump(data | {"contact": {"hardness": None}})

    made = run_messages.run_info
    monkeypatch.setattr(run_messages, "run_info", without_the_keys)
    run = Simulator(load_scenario("polygon", ["contact.exact=true"]))
    with record(tmp_path / "run.mcap", run) as push:
        push(run.advance(500))
    assert resimulate(tmp_path / "run.mcap").identical


@pytest.mark.slow
def test_a_run_says_how_contacts_were_found(capsys):
    assert main(["run", "polygon", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["contact"]["filtered_steps"] + found["contact"]["solved_steps"] == 2 * found["steps"]
    assert 0.0 < found["contact"]["largest_estimate_N"] < 98.1
    assert main(["run", "polygon", "--duration", "0.02"]) == 0
    assert "contacts without a force table:" in " ".join(capsys.readouterr().out.split())
