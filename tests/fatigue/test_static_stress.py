"""Static stress at stress nodes: mean, bending without damage, horizontal bending."""

import math

import numpy as np
import pytest

from support.toy import STATIC, toy_scenario, toy_simulator, toy_wheelset
from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.fatigue.static_stress import check_loads, static_stress
from wheelset_track_sim.scenario import scenario_from
from wheelset_track_sim.scenario.loads import Loads, TorquePoint
from wheelset_track_sim.wheelset.kinds import reduce_wheelset


def test_bending_is_that_of_the_static_load():
    simulator = toy_simulator()
    found = static_stress(simulator.scenario, simulator.models.reduced, ("A1", "C1"))
    load = simulator.scenario.wheel_load
    assert found.nodes == ("A1", "C1")
    assert found.bending == pytest.approx([sum(STATIC[name]) * load for name in ("A1", "C1")], rel=1e-6)
    assert found.amplitude.tolist() == found.bending.tolist()
    assert found.mean.tolist() == found.sideways.tolist() == [0.0, 0.0]


def test_given_stress_is_a_mean_and_no_bending():
    scenario = toy_scenario("loads.stresses=[{node: A1, yy: 30 MPa}]")
    reduced = reduce_wheelset(scenario.wheelset)
    found, without = (static_stress(each, reduced, ("A1", "B1")) for each in (scenario, toy_scenario()))
    assert found.mean == pytest.approx([30e6, 0.0])
    assert found.bending == pytest.approx(without.bending)
    shown = reduced.static_stress()[:2, 1] @ np.full(2, scenario.wheel_load) + found.mean
    assert found.bending_of(shown[np.newaxis])[0] == pytest.approx(found.bending)


def turned(*angles):
    """A toy scenario whose first nodes are at angles from the top."""
    wheelset = toy_wheelset()
    for node, angle in zip(wheelset["stress_nodes"], angles, strict=False):
        node["position"] = [0.09 * math.sin(angle), node["position"][1], 0.09 * math.cos(angle)]
    scenario = scenario_from(toy_scenario().to_mapping() | {"wheelset": wheelset})
    return scenario, reduce_wheelset(scenario.wheelset)


def test_a_node_at_the_side_is_left_out_with_a_warning():
    scenario, reduced = turned(math.pi / 2)
    with pytest.warns(InputWarning, match="stress nodes A1 are at the side of the axle"):
        assert static_stress(scenario, reduced, ("A1", "B1", "C1")).nodes == ("B1", "C1")
    with pytest.raises(InputError, match="stress nodes A1 do not show bending in the vertical plane: give"):
        static_stress(scenario, reduced, ("A1",))


def test_a_node_at_the_bottom_sees_the_opposite():
    scenario, reduced = turned(math.pi)
    found = static_stress(scenario, reduced, ("A1",))
    shown = reduced.static_stress()[0, 1] @ np.full(2, scenario.wheel_load)
    assert found.bending[0] == pytest.approx(-shown)


def test_horizontal_bending_needs_a_constant_torque():
    plan = (TorquePoint(0.0, 0.0), TorquePoint(1.0, 5e3))
    check_loads([Loads(torque_plan=plan), Loads(torque=100.0)])
    check_loads([Loads(torque=100.0, horizontal_bending=True)] * 2)
    for loads in (
        [Loads(torque_plan=plan, horizontal_bending=True)],
        [Loads(torque=100.0, horizontal_bending=True), Loads(torque=200.0, horizontal_bending=True)],
        [Loads(torque=100.0, horizontal_bending=True), Loads(horizontal_bending=True)],
    ):
        with pytest.raises(InputError, match=r"loads\.horizontal_bending follows a torque that changes"):
            check_loads(loads)
