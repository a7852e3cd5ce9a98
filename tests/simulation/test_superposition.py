"""Loads beside the contact forces: added to the stress and to nothing else, constant, over time, and changed live."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import Scenario, load_scenario, scenario_from
from wheelset_track_sim.scenario.loads import Loads, TorquePoint
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.simulation.superposition import TorqueCourse, superposition

STEPS = 600


@pytest.fixture(scope="module")
def smooth() -> Simulator:
    return Simulator(load_scenario("undamaged"))


@pytest.fixture(scope="module")
def unloaded(smooth: Simulator) -> np.ndarray:
    stresses: np.ndarray = Simulator(smooth.scenario, models=smooth.models).advance(STEPS).stresses
    return stresses


def under(loads: dict[str, object]) -> Scenario:
    return scenario_from({**load_scenario("undamaged").to_mapping(), "loads": loads})


def run(smooth: Simulator, loads: dict[str, object]) -> np.ndarray:
    stresses: np.ndarray = Simulator(under(loads), models=smooth.models).advance(STEPS).stresses
    return stresses


@pytest.mark.slow
def test_loads_superpose(smooth: Simulator, unloaded: np.ndarray) -> None:
    """Of press fit, given stress and torque together comes what each of them adds alone."""
    parts: list[dict[str, object]] = [
        {"press_fit": {"wheels": 2.5e-4, "equipment": 2e-4}},
        {"stresses": [{"node": "B1", "yy": 3e7, "xz": -1e6}]},
        {"torque": 9000.0},
        {"own_weight": True},
        {"lateral": {"wheel_1": 3e4, "wheel_2": -1e4}},
    ]
    together: dict[str, object] = {}
    for part in parts:
        together |= part
    added = [run(smooth, part) - unloaded for part in parts]
    assert run(smooth, together) - unloaded == pytest.approx(sum(added), abs=1.0)
    assert run(smooth, {"torque": -4500.0}) - unloaded == pytest.approx(-0.5 * added[2], abs=1.0)
    assert added[1][:, 1] == pytest.approx(np.tile([0.0, 3e7, 0.0, 0.0, -1e6, 0.0], (STEPS, 1)), abs=1.0)
    assert (added[0][:, :, 1] > 1e7).all()
    assert added[2][:, 0, 3] == pytest.approx(-added[2][:, 2, 3], rel=0.1)  # of both sides of the gearbox
    assert (added[3][:, :, 1] < -5e6).all()
    assert (added[4][:, 0, 1] > 1.2 * added[4][:, 1, 1]).all()  # bending is largest at wheel 1


def test_what_does_not_change_as_the_axle_turns_is_the_mean(smooth: Simulator, unloaded: np.ndarray) -> None:
    """Bending is what is left of the stress along the axle; torque has none there."""
    loads: dict[str, object] = {"press_fit": {"wheels": 2.5e-4}, "stresses": [{"node": "B1", "yy": 3e7}], "torque": 9e3}
    simulator = Simulator(under(loads), models=smooth.models)
    along = simulator.advance(STEPS).stresses[:, :, 1] - simulator.constant_stress[:, 1]
    assert along == pytest.approx(unloaded[:, :, 1], abs=1e4)
    assert simulator.constant_stress[0, 1] > 1e7
    for bending in ({}, {"own_weight": True}):  # which a point of the axle sees as tension and compression in turn
        simulator = Simulator(under(bending), models=smooth.models)
        assert simulator.constant_stress == pytest.approx(np.zeros((3, 6)), abs=1.0)


def test_forces_know_nothing_of_loads(smooth: Simulator) -> None:
    one, other = (
        Simulator(scenario, models=smooth.models).advance(STEPS)
        for scenario in (smooth.scenario, under({"torque": 9000.0}))
    )
    assert np.array_equal(one.forces, other.forces)
    # On Mohr's circle the shear of the torque turns the principal stress out of the plane of bending.
    assert (other.max_principal > one.max_principal + 1e5).all()


def test_torque_over_time(smooth: Simulator, unloaded: np.ndarray) -> None:
    plan = [{"time": 0.005, "torque": 0.0}, {"time": 0.015, "torque": 8000.0}]
    added = run(smooth, {"torque_plan": plan})[:, 0, 3] - unloaded[:, 0, 3]
    per_torque = (run(smooth, {"torque": 8000.0})[0, 0, 3] - unloaded[0, 0, 3]) / 8000.0
    times = np.arange(STEPS) * smooth.step_period
    expected = per_torque * np.clip((times - 0.005) / 0.010, 0.0, 1.0) * 8000.0
    assert added == pytest.approx(expected, abs=1.0)


def test_horizontal_bending_follows_the_torque(smooth: Simulator) -> None:
    """Nothing but shear on the top; at the front bending that is nothing on the top, in the same axes."""
    models = smooth.models
    plan = (TorquePoint(0.0, 0.0), TorquePoint(1.0, 8000.0))
    twisted, both = (
        superposition(Loads(torque_plan=plan, horizontal_bending=bent), models.wheelset, models.reduced, ("A1", "B1"))
        for bent in (False, True)
    )
    assert twisted is not None
    assert both is not None
    times = np.array([0.0, 0.5, 2.0])
    added = (both.stresses(times) - twisted.stresses(times)).reshape(2, 6, 3)
    assert added[:, [0, 1, 2, 5]] == pytest.approx(0.0, abs=1e-3)
    front = both.of_torque.polar(np.array([np.pi / 2, -np.pi / 2]))[:, 1]
    # 8 kN m: 18.5 kN on both wheels, 0.28 m from the axle boxes, at B1 on a shaft of 180 mm with a notch.
    assert 4.4e6 < 8000.0 * front[1, 0] < 8e6
    assert front[:, 1] == pytest.approx(-front[:, 0])


def test_the_same_however_it_is_cut(smooth: Simulator) -> None:
    plan = {"torque_plan": [{"time": 0.001, "torque": 0.0}, {"time": 0.02, "torque": 8000.0}]}
    whole = Simulator(under(plan), models=smooth.models).advance(STEPS)
    cut = Simulator(under(plan), models=smooth.models)
    blocks = [cut.advance(steps) for steps in (1, 99, 500)]
    assert np.array_equal(whole.stresses, np.concatenate([block.stresses for block in blocks]))


def test_torque_changes_live(smooth: Simulator, unloaded: np.ndarray) -> None:
    """From its step on it is approached at its rate, from the torque in force, and ends a plan."""
    rate = 1e6
    simulator = Simulator(under({"torque": 2000.0, "torque_rate": rate}), models=smooth.models)
    first = simulator.advance(100)
    changed = replace(simulator.scenario, loads=replace(simulator.scenario.loads, torque=-3000.0))
    revision = simulator.apply(changed)
    assert (revision.number, revision.step) == (1, 100)
    second = simulator.advance(STEPS - 100)
    assert second.revision == 1
    found = np.concatenate([first.stresses, second.stresses])[:, 0, 3] - unloaded[:, 0, 3]
    per_torque = found[0] / 2000.0
    since = (np.arange(STEPS) - 100) * smooth.step_period
    expected = per_torque * (2000.0 - 5000.0 * np.clip(since * rate / 5000.0, 0.0, 1.0))
    assert found == pytest.approx(expected, abs=1.0)
    gone = replace(changed, loads=replace(changed.loads, torque=0.0))
    simulator.apply(gone)
    simulator.advance(300)
    assert simulator.advance(10).stresses[:, :, 3] == pytest.approx(0.0, abs=1.0)


def test_torque_comes_where_there_was_none(smooth: Simulator) -> None:
    simulator = Simulator(smooth.scenario, models=smooth.models)
    simulator.advance(50)
    simulator.apply(replace(simulator.scenario, loads=Loads(torque=5000.0, torque_rate=1e6)))
    block = simulator.advance(300)
    assert block.stresses[0, 0, 3] == 0.0
    assert block.stresses[-1, 0, 3] > 1e6


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        (
            {"torque": 100.0, "torque_at": ["disc"]},
            "loads.torque_at.0 = 'disc' is not a known part .* gearbox, wheel_1",
        ),
        ({"stresses": [{"node": "D1", "yy": 1e6}]}, "loads.stresses.0.node = 'D1' is not a known stress node"),
    ],
)
def test_what_the_wheelset_does_not_have_is_refused(smooth: Simulator, loads: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Simulator(under(loads), models=smooth.models)


def test_fixed_loads_do_not_change_during_a_run(smooth: Simulator) -> None:
    plan = [{"time": 0.0, "torque": 0.0}, {"time": 1.0, "torque": 100.0}]
    simulator = Simulator(under({"torque_plan": plan}), models=smooth.models)
    for change, message in (
        ({"press_fit": {"wheels": 1e-4}, "torque_plan": plan}, "loads.press_fit cannot change during a run"),
        ({"torque_plan": plan[:1]}, "loads.torque_plan cannot change"),
        ({"torque": 100.0, "torque_at": ["wheel_1"]}, "loads.torque_at cannot change"),
        ({"own_weight": True, "torque_plan": plan}, "loads.own_weight cannot change during a run: start a new one"),
        ({"lateral": {"wheel_1": 1e4}, "torque_plan": plan}, "loads.lateral cannot change"),
        ({"horizontal_bending": True, "torque_plan": plan}, "loads.horizontal_bending cannot change"),
    ):
        with pytest.raises(InputError, match=message):
            simulator.apply(under(change))
    assert simulator.scenario.loads.torque_plan


def test_nothing_is_worked_out_for_no_loads(smooth: Simulator) -> None:
    models = smooth.models
    assert superposition(Loads(), models.wheelset, models.reduced, ("A1",)) is None


@given(time=st.floats(0.0, 10.0), torque=st.floats(-2e5, 2e5), rate=st.floats(1.0, 1e7), later=st.floats(0.0, 1e3))
def test_a_torque_never_changes_faster_than_its_rate(time: float, torque: float, rate: float, later: float) -> None:
    course = TorqueCourse((1.0, 2.0), (0.0, 5000.0))
    now = course.at(np.array([time]))[0]
    after = course.approaching(time, torque, rate).at(np.array([time, time + later]))
    assert after[0] == pytest.approx(now, abs=1e-6)  # less is over within the rounding of the time
    assert abs(after[1] - now) <= rate * later * (1 + 1e-9) + 1e-6
    assert after[1] == pytest.approx(torque) or abs(after[1] - now) == pytest.approx(rate * later, rel=1e-6, abs=1e-6)
