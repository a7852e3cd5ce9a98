"""The damage meets the rail at other places of the bay."""

import dataclasses

import numpy as np
import pytest

from support.toy import toy_models, toy_scenario
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.simulation.places import advanced, at_places, runs
from wheelset_track_sim.simulation.simulator import Simulator


def test_places_are_even_and_the_first_one_is_the_scenarios():
    scenario = toy_scenario()
    found = at_places(scenario, 4)
    assert found[0] == scenario
    assert [each.reference_position for each in found] == pytest.approx([1.8, 1.95, 2.1, 2.25])
    far = at_places(dataclasses.replace(scenario, reference_position=5.9), 3)
    assert [each.reference_position for each in far] == pytest.approx([5.9, 5.5, 5.7])
    with pytest.raises(InputError, match="places = 0 is out of range: give 1 to 60 places of a bay"):
        at_places(scenario, 0)


@pytest.mark.slow
def test_a_run_at_a_place_is_that_of_a_scenario_with_it():
    scenario = toy_scenario(like="damage_wheel_1")
    _, there = at_places(scenario, 2)
    own = dataclasses.replace(toy_models(), tables="smooth", tread_origin=there.tread_origin)
    expected = Simulator(there, models=own)
    (run,) = runs((there,), toy_models())
    (block,) = advanced(run, 2713)
    assert np.array_equal(block.forces, expected.advance(2713).forces)
    assert abs(int(block.forces[:, 0].argmax()) - 2100) < 60
