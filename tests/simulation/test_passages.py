"""Passages of distinct defects: the bits of a run to which they are applied, the forces of one with force tables."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Breakout, Flat, Roughness, Squat
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import Models
from wheelset_track_sim.simulation.passages import Passages
from wheelset_track_sim.simulation.simulator import Simulator

FLAT = Flat("wheel_1", length=0.03)
BESIDE = Breakout("wheel_2", 0.02, 0.016, 0.0008, angle=0.3, y=0.003)
ROUGH = "irregularities=[{type: roughness, on: wheel_1, seed: 1}]"


@cache
def untabled(tolerance: float = 0.0) -> Models:
    return dataclasses.replace(toy_models(), tables="smooth", tolerance=tolerance, _smooth=None, _preloads={})


def toys(*changes: str, **window: float) -> Passages:
    scenario = toy_scenario(*changes)
    return Passages(scenario, models=untabled(scenario.contact.largest_estimate), **window)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("defects", "changes"),
    [
        ([FLAT], {}),
        ([Flat("wheel_2", length=0.03, worn_length=0.06), BESIDE], {"speed": 15.0, "axle_load": 150e3}),
        ([Squat("rail_1", position=1.75, a=0.03, b=0.02, h=4e-4)], {"speed": 40.0}),
    ],
    ids=["flat", "two", "rail"],
)
def test_a_passage_has_the_bits_of_a_run_to_which_the_defects_are_applied(defects, changes):
    passages = toys()
    passages.run([BESIDE])  # what others leave behind does not matter
    block = passages.run(defects, **changes)
    run = Simulator(dataclasses.replace(passages.scenario, **changes), models=untabled())
    run.settle()
    run.advance(900)
    run.apply(dataclasses.replace(run.scenario, irregularities=tuple(defects)), not_before=900, exactly=True)
    expected = run.advance(1801)
    assert (block.first_step, len(block)) == (900, 1801)
    assert np.array_equal(block.forces, expected.forces)
    assert np.array_equal(block.stresses, expected.stresses)
    assert block.forces.max() > 1.3 * passages.scenario.wheel_load


@pytest.mark.slow
def test_on_rough_wheels_a_passage_is_filtered_but_for_the_defect():
    passages = toys(ROUGH, "settle_on=surfaces", after=0.1, before=0.1)
    block, plain = passages.run([FLAT]), passages.run([])
    assert 0 < block.contacts.solved_steps < 100
    assert block.contacts.filtered_steps + block.contacts.solved_steps == 201
    assert plain.contacts.solved_steps < block.contacts.solved_steps
    assert np.array_equal(block.forces[:50], plain.forces[:50])


@pytest.mark.parametrize(
    ("defects", "window", "message"),
    [
        ([FLAT], {"before": 0.01}, "in the contact patch where the passage begins, at 1.79 m: give defects elsewhere"),
        ([Roughness("wheel_1", seed=1)], {}, "in the contact patch where the passage begins, at 0.9 m"),
    ],
)
def test_what_is_there_when_the_passage_begins_is_refused(defects, window, message):
    with pytest.raises(InputError, match=message):
        toys(**window).run(defects)


@pytest.mark.parametrize(
    ("changes", "window", "message"),
    [
        ((), {"before": 2.0}, "a passage from 2 m before to 0.9 m behind the reference position of 1.8 m is none"),
        ((), {"before": 0.5, "after": -0.6}, "is none: give a beginning behind step 0, and an end behind it"),
        (("speed_plan=[{time: 1, speed: 20}]",), {}, "speed_plan has no place in a passage: give speed"),
        (("events=[{time: 1, speed: 20}]",), {}, "events have no place in a passage: leave them out"),
    ],
)
def test_passages_that_cannot_be_are_refused(changes, window, message):
    with pytest.raises(InputError, match=message):
        toys(*changes, **window)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [12.0, 27.7777778])
@pytest.mark.parametrize("place", [0.0, 0.23, 0.45])
def test_forces_and_stresses_agree_with_a_run_with_force_tables(speed, place):
    """Within 1e-9 of the static load and of the largest stress: tables and solver differ by rounding."""
    scenario = load_scenario("undamaged", ["settle_on=smooth", f"speed={speed}"])
    passages, angle = _shipped(), place / scenario.wheelset.rolling_radius
    for defect in (
        Breakout("wheel_1", 0.03, 0.024, 0.002, angle=angle),
        Flat("wheel_1", length=0.045, angle=angle),
        Flat("wheel_2", length=0.04, worn_length=0.08, angle=angle),
    ):
        block = passages.run([defect], speed=speed)
        run = Simulator(dataclasses.replace(scenario, irregularities=(defect,)), models=_tabled())
        run.settle()
        run.advance(passages.first_step)
        whole = run.advance(passages.steps)
        assert np.abs(block.forces - whole.forces).max() < 1e-9 * scenario.wheel_load
        assert np.abs(block.stresses - whole.stresses).max() < 1e-9 * np.abs(whole.stresses).max()


@cache
def _shipped() -> Passages:
    return Passages(load_scenario("undamaged", ["settle_on=smooth"]))


@cache
def _tabled() -> Models:
    return dataclasses.replace(_shipped()._models, tables=True, _smooth=None, _preloads={})


@pytest.mark.slow
def test_the_place_of_the_impact_is_that_of_the_angle():
    at = math.tau * 0.05
    here, there = (toys(after=1.2).run([dataclasses.replace(FLAT, angle=angle)]) for angle in (0.0, at))
    steps = round(at / math.tau * untabled().steps_per_revolution)
    assert abs(there.forces[:, 0].argmax() - here.forces[:, 0].argmax() - steps) < 20
