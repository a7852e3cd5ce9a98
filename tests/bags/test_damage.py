import dataclasses
import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.drawn import BREAKOUTS
from wheelset_track_sim.bags.definitions import typestore
from wheelset_track_sim.bags.tread_damage import FIELDS, MOST, damage_fields, irregularities_of
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Breakout


def item(**changes):
    """A TreadDamage as ROS makes it: what is not given is 0."""
    return SimpleNamespace(
        **{"kind": 0, "angle": 0.0, "y": 0.0, "wheel": 1, "a": 0.03, "b": 0.024, "h": 0.002, **changes}
    )


def test_fields_are_those_of_the_message():
    assert tuple(name for name, _ in typestore().fielddefs["wheelset_track_msgs/msg/TreadDamage"][1]) == FIELDS


@given(st.lists(BREAKOUTS, max_size=6))
def test_any_damage_comes_back(breakouts):
    told = [SimpleNamespace(**fields) for fields in damage_fields(breakouts)]
    assert irregularities_of(told) == tuple(breakouts)


def test_a_depth_of_0_is_no_damage_but_is_checked():
    assert irregularities_of([item(h=0.0), item(wheel=2), item(h=-0.0)]) == (Breakout("wheel_2", 0.03, 0.024, 0.002),)
    with pytest.raises(InputError, match=r"^damage\.0\.a = nan is not finite"):
        irregularities_of([item(h=0.0, a=math.nan)])


REFUSALS = {
    "a": (0.3, r"damage\.1\.a = 0\.3 m is out of range: give longitudinal semi-axis from 0\.001 to 0\.2 m"),
    "h": (math.inf, r"damage\.1\.h = inf is not finite"),
    "angle": (math.nan, r"damage\.1\.angle = nan is not finite"),
    "y": (0.049, r"damage\.1\.b = 0\.024 m at y = 0\.049 m reaches 0\.073 m from the rolling circle"),
    "wheel": (3, r"damage\.1\.wheel = 3 is not a wheel: give 1 \(far from the gearbox\) or 2"),
    "kind": (7, r"damage\.1\.kind = 7 is not a kind of damage: known are 0 \(breakout\)"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_refusals_name_entry_quantity_value_and_limit(name):
    value, message = REFUSALS[name]
    with pytest.raises(InputError, match=f"^{message}"):
        irregularities_of([item(), item(**{name: value})])


def test_too_many_are_refused_before_they_are_looked_at():
    with pytest.raises(InputError, match=f"damage has {MOST + 1} entries: give at most {MOST}"):
        irregularities_of([None] * (MOST + 1))
    assert len(irregularities_of([item()] * MOST)) == MOST


def test_every_number_of_a_breakout_is_in_the_message():
    assert {field.name for field in dataclasses.fields(Breakout)} - {"on"} == set(FIELDS) - {"wheel", "kind"}
