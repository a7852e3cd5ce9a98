"""Runs of studies that are cut by a change of speed."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import SetPoint, load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.studies.evaluate import Job, Result, evaluate, models, program

PLAN = (SetPoint(0.04, 28.6), SetPoint(0.065, 27.0))


def job() -> Job:
    scenario = load_scenario("damage_wheel_1", ["acceleration=10", "irregularities.0.h=0.0003"])
    return Job(
        dataclasses.replace(scenario, speed_plan=PLAN),
        before=1.0,
        after=1.0,
        outputs=("wheels.wheel_1.max_force", "nodes.A1.max_principal"),
        histories=("forces", "displacements"),
        pressures=("wheel_1.reference", "wheel_1.max_force"),
    )


@pytest.fixture(scope="module")
def found() -> Result:
    return evaluate(job(), program())


@pytest.mark.slow
def test_histories_go_through_a_change_of_speed(found: Result) -> None:
    one = job()
    simulator = Simulator(one.scenario)
    blocks = []
    while simulator.next_step < one.first_step + one.samples:
        blocks.append(simulator.advance(one.first_step + one.samples - simulator.next_step))
    assert len({block.speed for block in blocks if block.first_step > one.first_step}) == 3
    forces = np.concatenate([block.forces for block in blocks])[one.first_step :]
    # the study has the defect solved, not tabulated
    assert found.arrays["forces"] == pytest.approx(forces, rel=1e-3, abs=100.0)
    assert found.arrays["displacements"].shape == (one.samples, 2, 2)
    assert np.diff(found.arrays["position"]) == pytest.approx(np.full(one.samples - 1, 1e-3))
    last = [block for block in blocks if block.first_step >= one.first_step]
    largest = max(summarise(block).nodes[0].max_principal for block in last)
    assert found.values["nodes.A1.max_principal"] == pytest.approx(largest, rel=1e-3)


@pytest.mark.slow
def test_outputs_of_fatigue_are_those_of_the_window() -> None:
    names = ("nodes.C1.damage_ratio", "nodes.C1.rotating_amplitude", "nodes.A1.max_principal")
    curve = load_curve("assumed_body")
    one = dataclasses.replace(job(), after=6.0, outputs=names, histories=(), pressures=(), curve=curve)
    simulator = Simulator(one.scenario, models=models(one.scenario))
    simulator.settle()
    while simulator.next_step < one.first_step:
        simulator.advance(one.first_step - simulator.next_step)
    static = static_stress(one.scenario, simulator.models.reduced, ["C1"])
    fatigue = AxleFatigue(static, TurningWheel.of(one.scenario), curve)
    while fatigue.steps < one.samples:
        fatigue.push(simulator.advance(one.samples - fatigue.steps))
    values = evaluate(one, program()).values
    [node] = fatigue.nodes
    assert [values[name] for name in names[:2]] == [node.ratios[0], node.amplitude]
    assert node.ratios[0] > 1.0
    assert values["nodes.A1.max_principal"] > 60e6


def test_pressures_are_of_the_whole_run(found: Result) -> None:
    force = found.arrays["forces"][:, 0]
    position, largest, _ = found.arrays["wheel_1.max_force.at"]
    assert largest == pytest.approx(force.max(), rel=1e-6)
    assert position == pytest.approx(found.arrays["position"][force.argmax()])
    assert found.values["wheels.wheel_1.max_force"] == force.max()
    position, at_reference, circle = found.arrays["wheel_1.reference.at"]
    assert position == pytest.approx(1.8)
    assert circle == 0.0
    assert at_reference == pytest.approx(force[1000], rel=1e-6)
