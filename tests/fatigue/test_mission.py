"""Missions: validated whole, and added up by shares and stages."""

import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.axle import NodeFatigue
from wheelset_track_sim.fatigue.mission import Leg, Mission, Stage, load_mission, mission_damage
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario

ANGLES = np.array([0.0, 1.0, 2.0])
TWO = Mission("two legs", (Leg(0.25, name="slow"), Leg(0.75)), (Stage(0.0), Stage(100.0)))


def sample(rates, distance=10.0):
    """Damage of two rules at three points by the rates of the first rule, 1/m; the second does a tenth, or none."""
    damage = np.array([[rate, 0.1 * rate if rate > 2e-3 else 0.0] for rate in rates]) * distance
    undamaged = np.array([1e-3, 0.0]) * distance
    return (NodeFatigue("A1", distance, 80e6, 0.0, 60e6, ANGLES, damage, undamaged, 1e8),)


FOUND = [
    [sample([1e-3, 2e-3, 1e-3]), sample([1e-3, 4e-3, 2e-3], distance=20.0)],
    [sample([8e-3, 0.0, 1e-3]), sample([0.0, 0.0, 40e-3])],
]


def test_damage_is_that_of_shares_and_stages():
    (node,) = mission_damage(TWO, FOUND)
    np.testing.assert_allclose(node.damage(50.0)[:, 0], 50 * np.array([1e-3, 3.5e-3, 1.75e-3]))
    second = 100 * np.array([1e-3, 3.5e-3, 1.75e-3]) + 30 * np.array([2e-3, 0.0, 30.25e-3])
    np.testing.assert_allclose(node.damage(130.0)[:, 0], second)
    assert [node.worst(50.0), node.worst(130.0)] == [1, 2]
    np.testing.assert_allclose(node.undamaged(130.0), [0.13, 0.0])
    np.testing.assert_allclose(node.leg_shares(50.0), [0.25 * 2 / 3.5, 0.75 * 4 / 3.5])
    assert node.amplitude == 80e6


def test_life_is_the_distance_at_which_a_point_reaches_damage_1():
    (node,) = mission_damage(TWO, FOUND)
    life = node.life()
    assert life[0] == pytest.approx(100 + (1 - 0.175) / 30.25e-3)
    for rule, distance in enumerate(life):
        assert node.damage(distance)[:, rule].max() == pytest.approx(1.0)
    early = node.life(0.2)
    assert early[0] == pytest.approx(0.2 / 3.5e-3)  # within the first stage
    (endless,) = mission_damage(
        dataclasses.replace(TWO, growth=(Stage(0.0),)), [[sample([1e-3, 1e-3, 1e-3]), sample([0.0, 0.0, 0.0])]]
    )
    assert math.isinf(endless.life()[1])


def test_distances_are_cut_at_the_stages():
    assert TWO.lengths(60.0) == [60.0, 0.0]
    assert TWO.lengths(260.0) == [100.0, 160.0]


def test_scenarios_have_the_changes_of_leg_and_stage():
    mission = load_mission("intercity")
    scenarios = mission.scenarios(load_scenario("damage_wheel_1"))
    assert [[round(each.speed * 3.6) for each in legs] for legs in scenarios] == [[60, 100, 140]] * 3
    assert [legs[0].irregularities[0].h for legs in scenarios] == [0.5e-3, 1e-3, 2e-3]
    assert scenarios[0][2].axle_load == pytest.approx(19 * 9810.0)


@pytest.mark.parametrize("name", shipped.names("missions"))
def test_shipped_missions_say_that_they_are_assumed(name):
    assert "assumed" in shipped.text("missions", name).partition("title:")[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title: x", "legs is missing"),
        ("title: x\nlegs: []", "legs or growth is empty"),
        ("title: x\nlegs: [{share: 0.5}]", "shares of 0.5 in all: give shares that add up to 1"),
        ("title: x\nlegs: [{share: 1, speed: 400 km/h}]", "legs.0.speed = 400 km/h"),
        ("title: x\nlegs: [{share: 1, sped: 20}]", "legs.0.sped is not a known key: did you mean speed"),
        ("title: x\nlegs: [{share: 1, set: [1]}]", "not a mapping"),
        ("title: x\nlegs: [{share: 1}]\ngrowth: [{after: 5 km}]", "begin with a stage after 0 m"),
        ("title: x\nlegs: [{share: 1}]\ngrowth: [{after: 0}, {after: 5}, {after: 5}]", "growth.2.after = 5 m is not"),
        ("title: x\nlegs: [{share: 1}]\nsample: 1 mm", "sample = 1 mm"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "mission.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as refusal:
        load_mission(path)
    assert "\n" not in str(refusal.value)


def test_changes_that_the_scenario_cannot_have_name_their_place():
    undamaged = load_scenario("undamaged")
    with pytest.raises(InputError, match=r"growth\.0\.set"):
        load_mission("intercity").scenarios(undamaged)
    wrong = dataclasses.replace(TWO, growth=(Stage(0.0, {"axle_load": 1.0}),))
    with pytest.raises(InputError, match=r"axle_load = 1 N is out of range.*\(slow\)"):
        wrong.scenarios(undamaged)
    planned = load_scenario("line_speeds")
    with pytest.raises(InputError, match="speed_plan or events"):
        TWO.scenarios(planned)
