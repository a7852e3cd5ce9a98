import dataclasses
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from support.drawn import BREAKOUTS
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.inputs.shipped import names
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.scenario.values import SIZE_C, values_of, with_values

BASE = load_scenario("undamaged")


def within_the_limit(breakouts):
    """Whether breakouts that lie over one another are not too deep together."""
    return sum(item.h for item in breakouts) < 0.02


@pytest.mark.parametrize("name", names("scenarios"))
def test_shipped_scenarios_come_back_unchanged(name):
    scenario = load_scenario(name)
    assert with_values(scenario, values_of(scenario)) == scenario


@given(st.lists(BREAKOUTS, max_size=5).filter(within_the_limit), st.floats(5, 100), st.floats(2e4, 4e5))
def test_any_scenario_comes_back_unchanged(breakouts, speed, axle_load):
    scenario = dataclasses.replace(BASE, speed=speed, axle_load=axle_load, irregularities=tuple(breakouts))
    assert with_values(scenario, values_of(scenario)) == scenario


@given(st.lists(BREAKOUTS, max_size=5).filter(within_the_limit), BREAKOUTS)
def test_parameters_replace_the_first_breakout_of_a_wheel_and_leave_the_rest(breakouts, new):
    assume(within_the_limit([*breakouts, new]))
    scenario = dataclasses.replace(BASE, irregularities=tuple(breakouts))
    given = {f"{new.on}.damage.{name}": getattr(new, name) for name in SIZE_C}
    changed = with_values(scenario, values_of(scenario) | given)
    of_wheel = [item for item in changed.irregularities if item.on == new.on]
    assert of_wheel[0] == new
    assert of_wheel[1:] == [item for item in breakouts if item.on == new.on][1:]
    others = [item for item in changed.irregularities if item.on != new.on]
    assert others == [item for item in breakouts if item.on != new.on]


def test_depth_zero_takes_the_breakout_away():
    both = load_scenario("damage_both")
    smooth = with_values(both, values_of(both) | {"wheel_1.damage.h": 0.0})
    assert smooth.irregularities == tuple(item for item in both.irregularities if item.on == "wheel_2")


@pytest.mark.parametrize("name", [*values_of(BASE)])
@pytest.mark.parametrize("value", [math.nan, math.inf, -1e9])
def test_refusals_name_the_parameter(name, value):
    with pytest.raises(InputError, match=f"^{name} = "):
        with_values(BASE, values_of(BASE) | {name: value})
