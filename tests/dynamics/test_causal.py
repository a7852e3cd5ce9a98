import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.dynamics.causal import CausalModel, causal_model
from wheelset_track_sim.dynamics.causal_kernels import advance, displacements, stresses
from wheelset_track_sim.dynamics.running_wheelset import truncated
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator

DX, SPEED, LOAD = 1e-3, 100 / 3.6, 98.1e3


@pytest.fixture(scope="module")
def model() -> CausalModel:
    dynamics = load_models(load_scenario("undamaged")).dynamics
    assert isinstance(dynamics, CausalModel)
    return dynamics


def stepped(model: CausalModel, steps: int, load: float = LOAD, start: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Displacements (steps, 2, 2) and stresses under constant forces, from rest under them."""
    dynamics = model.start(load, start, DX, SPEED)
    xi, stress = np.zeros((steps, 2, 2)), np.zeros((steps, len(model.stress_rows)))
    forces = np.full(2, load)
    for n in range(steps):
        displacements(dynamics, start + n, xi[n])
        xi[n, 0] += dynamics.wheel_compliance * load
        xi[n, 1] += dynamics.rail_compliance[(start + n) % len(dynamics.rail_compliance)] * load
        stresses(dynamics, forces, stress[n])
        advance(dynamics, start + n, forces)
    return xi, stress


@pytest.mark.slow
def test_statics_of_wheelset_and_stress_stay_for_ever(model: CausalModel) -> None:
    xi, stress = stepped(model, 3000)
    wheels = model.wheelset.static_receptance().sum(axis=1) * LOAD
    assert xi[:, 0] == pytest.approx(np.broadcast_to(wheels, (3000, 2)), rel=1e-6)
    static = model.wheelset.static_stress().sum(axis=-1).ravel()[model.stress_rows] * LOAD
    assert stress == pytest.approx(np.broadcast_to(static, stress.shape), rel=1e-3, abs=1.0)


@pytest.mark.parametrize("start", [0, 150, -311])
def test_the_rail_starts_at_rest_under_the_load(model: CausalModel, start: int) -> None:
    xi, _ = stepped(model, 1, start=start)
    expected = model.track.symmetric.compliance()[start % 600] * LOAD
    # what crosses the sleepers at lag zero is left out: 5e-13 m/N
    assert xi[0, 1] == pytest.approx([expected, expected], rel=1e-4)


def test_the_preload_is_what_the_load_displaces(model: CausalModel) -> None:
    xi, _ = stepped(model, 6000)
    assert xi[-600:].sum(axis=1).mean(axis=0) == pytest.approx(model.preload(LOAD, DX, SPEED), rel=2e-3)


def test_nobody_need_ask_for_stress() -> None:
    simulator = Simulator(load_scenario("damage_wheel_1", ["output.stress_nodes=[]"]))
    block = simulator.advance(2000)
    assert block.stresses.shape == (2000, 0, 6)
    assert summarise(block).nodes == ()
    stressed = Simulator(load_scenario("damage_wheel_1")).advance(2000)  # its modes are in another order
    assert block.forces == pytest.approx(stressed.forces, abs=1e-3)


def test_doubled_forces_double_everything(model: CausalModel) -> None:
    once, twice = stepped(model, 700), stepped(model, 700, 2 * LOAD)
    for one, two in zip(once, twice, strict=True):
        assert two == pytest.approx(2 * one, rel=1e-12, abs=1e-15)


def test_no_force_crosses_axle_or_sleepers_within_a_step(model: CausalModel) -> None:
    """What the coupled step leaves out at lag zero, against what it has."""
    dynamics = model.start(0.0, 0, DX, SPEED)
    advance(dynamics, 0, np.array([1.0, 0.0]))
    xi = np.zeros((2, 2))
    displacements(dynamics, 1, xi)
    assert abs(xi[0, 1]) < 1e-2 * abs(xi[0, 0])
    assert abs(xi[1, 1]) < 3e-3 * abs(xi[1, 0])  # 1.5e-3: the reach of the band limit


@pytest.mark.parametrize("limit", [500.0, 2500.0])
def test_modes_left_out_keep_their_statics(model: CausalModel, limit: float) -> None:
    short = truncated(model.wheelset, limit)
    assert short.frequencies.max() <= limit
    assert short.static_stress() == pytest.approx(model.wheelset.static_stress(), rel=1e-9, abs=1e-6)
    compliance = short.static_receptance() + short.displacement_residual
    assert compliance == pytest.approx(
        model.wheelset.static_receptance() + model.wheelset.displacement_residual, rel=1e-9
    )


def test_modes_beyond_one_bank_fill_the_next(model: CausalModel) -> None:
    """Each mode cut into two equal ones is the same wheelset."""
    whole = model.wheelset
    cut = dataclasses.replace(
        whole,
        poles=np.repeat(whole.poles, 2),
        inputs=np.repeat(whole.inputs, 2, axis=0) / 2,
        outputs=np.repeat(whole.outputs, 2, axis=1),
        stress_outputs=np.repeat(whole.stress_outputs, 2, axis=2),
    )
    twice = causal_model(cut, model.track, ["A1", "B1", "C1"], "residual")
    assert len(twice.start(LOAD, 0, DX, SPEED).wheels) == 2
    for one, two in zip(stepped(model, 700), stepped(twice, 700), strict=True):
        assert two == pytest.approx(one, rel=1e-5, abs=1e-12)


def test_modes_that_answer_at_once_keep_their_statics(model: CausalModel) -> None:
    summed = model.stress_output.shape[1]
    assert summed < len(model.wheelset.poles)
    modal = model.wheelset.inputs[:summed] / model.wheelset.poles[:summed, np.newaxis]
    static = model.stress_feedthrough - (model.stress_output @ modal).real
    expected = model.wheelset.static_stress().reshape(-1, 2)[model.stress_rows]
    assert static == pytest.approx(expected, rel=1e-9, abs=1e-9)
