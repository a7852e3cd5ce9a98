from __future__ import annotations

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.scenario.loads import Loads


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
            "loads.torque_plan=[{time: 1, torque: 0}, {time: 1, torque: 5}]",
            "loads.torque_plan.1.time = 1 s is not af",
        ),
        ("loads.torque_at=[]", "loads.torque_at is empty"),
        ("loads.wheel_1_share=1.5", "wheel_1_share = 1.5 is out of range"),
        ("loads.stresses=[{node: A1, yy: x}]", "loads.stresses.0.yy = 'x' is not a number"),
        (
            "loads={torque: 1.0, torque_plan: [{time: 0, torque: 0}]}",
            "loads.torque = 1 N m stands beside",
        ),
    ],
)
def test_bad_loads_are_refused(change: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as refusal:
        load_scenario("undamaged", [change])
    assert "\n" not in str(refusal.value)
