"""Verdicts: each value against limits of its own quantity."""

import math

import pytest

from wheelset_track_sim.irregularities import Breakout, Flat
from wheelset_track_sim.verdict.limit_set import Level, LimitSet, StressLimit, load_limits
from wheelset_track_sim.verdict.verdicts import damage_lengths, verdicts, worst

STATED = {"action": "inspect", "source": "a drawing", "zone": "body", "grade": "EA1N"}
AXLE = LimitSet(
    "axle",
    axle=(
        StressLimit(level="warning", above=80e6, nodes=("A1", "C1"), **STATED),
        StressLimit(level="alarm", above=100e6, nodes=("A1",), **STATED),
    ),
)


def test_forces_and_lengths_are_compared_with_limits_of_their_own():
    damage = [Breakout("wheel_1", a=0.031, b=0.024, h=1e-3), {"type": "polygon", "on": "wheel_2"}]
    found = verdicts(load_limits("trafikverket"), (349e3, 351e3), damage)
    assert [(each.subject, each.quantity, each.level) for each in found] == [
        ("wheel_1", "contact_force", Level.OK),
        ("wheel_2", "contact_force", Level.ERROR),
        ("wheel_1", "damage_length", Level.ERROR),
    ]
    assert found[0].text == "wheel 1: largest contact force 349 kN is within 350 kN (trafikverket)"
    assert "351 kN is above 350 kN: stop the train" in found[1].text
    assert found[2].mapping["value_m"] == 0.062
    assert worst(found) == Level.ERROR


def test_a_value_at_the_limit_is_within_it():
    found = verdicts(load_limits("trafikverket"), (350e3, 0.0), [Breakout("wheel_1", a=0.03, b=0.024, h=1e-3)])
    assert worst(found) == Level.OK


@pytest.mark.parametrize(
    ("force", "level", "limit"),
    [(300e3, Level.OK, 355858), (360e3, Level.WARN, 355858), (410e3, Level.ERROR, 400340)],
)
def test_of_several_limits_the_worst_that_is_exceeded_decides(force, level, limit):
    found, _ = verdicts(load_limits("fra"), (force, 0.0))
    assert (found.level, found.limit.above) == (level, limit)


def test_axle_stress_is_compared_at_the_nodes_of_the_zone_only():
    found = verdicts(AXLE, (5e5, 5e5), (), {"A1": 101e6, "B1": 300e6, "C1": 81e6})
    assert [(each.subject, each.level) for each in found] == [("A1", Level.ERROR), ("C1", Level.WARN)]
    assert found[0].text == "A1: bending amplitude 101 MPa is above 100 MPa: inspect (axle)"
    assert not verdicts(AXLE, (0.0, 0.0), (), {"A1": math.nan})
    assert worst(()) == Level.OK


def test_lengths_are_those_along_the_tread_of_the_longest_damage():
    plain = [
        {"type": "flat", "on": "wheel_2", "length": 0.05, "worn_length": 0.07},
        {"type": "flat", "on": "wheel_2", "length": 0.06},
        {"type": "corrugation", "on": "rail_1"},
    ]
    assert damage_lengths([*plain, Flat("wheel_1", length=0.04)]) == {"wheel_1": 0.04, "wheel_2": 0.07}
