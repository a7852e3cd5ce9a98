from __future__ import annotations

import dataclasses

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.scenario.loads import Loads
from wheelset_track_sim.wheelset.harmonics import GRAVITY
from wheelset_track_sim.wheelset.kinds import mass_of


def test_without_loads_nothing_is_superposed() -> None:
    assert load_scenario("undamaged").loads == Loads()
    assert Loads().none
    assert not load_scenario("undamaged", ["loads.press_fit.wheels=2e-4"]).loads.none
    assert not load_scenario("undamaged", ["loads.torque=-100"]).loads.none


def test_loads_come_back_from_their_own_mapping() -> None:
    changes = [
        "loads.stresses=[{node: A1, yy: 4.0e7}]",
        "loads.torque_plan=[{time: 0, torque: 0}, {time: 2, torque: 8000}]",
        "loads.torque_at=[wheel_1]",
    ]
    scenario = load_scenario("undamaged", changes)
    assert scenario_from(scenario.to_mapping()) == scenario
    assert scenario.loads.torque_plan[1].torque == 8000.0
    assert scenario.loads.stresses[0].components == (0.0, 4e7, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("loads.torque=.inf", "loads.torque = inf is not finite"),
        ("loads.torque=3e5", "loads.torque = 300000 N m is out of range"),
        ("loads.press_fit.wheels=0.01", "loads.press_fit.wheels = 0.01 m is out of range"),
        ("loads.press_fit.wheel=0.0001", "did you mean wheels"),
        (
            "loads.torque_plan=[{time: 1, torque: 0}, {time: 1, torque: 500}]",
            "loads.torque_plan.1.time = 1 s is not af",
        ),
        ("loads.torque_at=[]", "loads.torque_at is empty"),
        ("loads.own_weight=1", "loads.own_weight = 1 is not of type bool: give true or false"),
        ("loads.lateral.wheel_1=3e5", "loads.lateral.wheel_1 = 300000 N is out of range"),
        ("loads.lateral.wheel_3=1e5", "loads.lateral.wheel_3 is not a known key"),
        ("loads.horizontal_bending=.nan", "loads.horizontal_bending = nan is not of type bool"),
        ("loads.wheel_1_share=1.5", "wheel_1_share = 1.5 is out of range"),
        ("loads.stresses=[{node: A1, yy: x}]", "loads.stresses.0.yy = 'x' is not a number"),
        (
            "loads={torque: 1000.0, torque_plan: [{time: 0, torque: 0}]}",
            "loads.torque = 1000 N m and loads.torque_plan exclude each other",
        ),
    ],
)
def test_bad_loads_are_refused(change: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as refusal:
        load_scenario("undamaged", [change])
    assert "\n" not in str(refusal.value)


def test_bending_loads_are_loads() -> None:
    for change in ("loads.own_weight=true", "loads.lateral.wheel_2=-1 N"):
        assert not load_scenario("undamaged", [change]).loads.none
    for change in ("loads.own_weight=false", "loads.lateral.wheel_2=0", "loads.horizontal_bending=true"):
        assert load_scenario("undamaged", [change]).loads.none  # there is no torque yet to which rails could react


def test_an_axle_load_below_the_own_weight_is_refused() -> None:
    scenario = load_scenario("undamaged", ["loads.own_weight=true"])
    boxes = dataclasses.replace(scenario.wheelset.axle_boxes, mass=600.0)
    heavy = dataclasses.replace(scenario, wheelset=dataclasses.replace(scenario.wheelset, axle_boxes=boxes))
    weight = GRAVITY * mass_of(heavy.wheelset)
    assert dataclasses.replace(heavy, axle_load=weight).axle_load > 2e4
    with pytest.raises(
        InputError, match=r"axle_load = 26000 N is less than the wheelset weighs alone, 267\d\d N: give"
    ):
        dataclasses.replace(heavy, axle_load=2.6e4)
    assert dataclasses.replace(heavy, axle_load=2.6e4, loads=Loads()).loads.none
