"""Stresses from contact forces alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelset_track_sim.dynamics.stress_from_forces import stresses_from_forces
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import reduced_wheelset


@pytest.fixture(scope="module")
def wheelset() -> ReducedWheelset:
    return reduced_wheelset(load_wheelset("x40"))


@settings(max_examples=20)
@given(st.floats(-2e5, 4e5), st.floats(-2e5, 4e5), st.sampled_from([2e-5, 1e-4, 1e-3]))
def test_constant_forces_give_the_static_stress(wheelset: ReducedWheelset, one: float, two: float, dt: float) -> None:
    found = stresses_from_forces(wheelset, np.tile([one, two], (20, 1)), dt)
    np.testing.assert_allclose(found, np.tile(wheelset.static_stress() @ [one, two], (20, 1, 1)), atol=1e-3)


@pytest.mark.parametrize(
    ("frequency", "dt"),
    [
        (50.0, 1e-3),
        pytest.param(900.0, 1e-4, marks=pytest.mark.slow),
        pytest.param(1919.0, 4e-5, marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_a_steady_wave_gives_the_stress_receptance(wheelset: ReducedWheelset, frequency: float, dt: float) -> None:
    """Independent of any step: the frequency response of the same poles."""
    time = np.arange(round(4.0 / dt)) * dt
    wave = np.exp(2j * np.pi * frequency * time)
    forces = np.stack([1e4 * wave.real, 4e3 * wave.imag], axis=-1)
    found = stresses_from_forces(wheelset, forces, dt)
    expected = wheelset.stress_receptance(np.array([frequency]))[0] @ np.array([1e4, -4e3j])
    late = time > 3.5
    steady = np.einsum("t,tnc->nc", wave[late].conj(), found[late]) * 2 / late.sum()
    # A straight line between the samples that the wheelset is stepped with is lower than the wave by sinc^2.
    lower = np.sinc(frequency * dt / max(1, np.ceil(dt * 25e3))) ** 2
    assert np.abs(steady - lower * expected).max() < 0.004 * np.abs(expected).max()


@pytest.mark.slow
def test_the_forces_of_a_simulation_give_its_stresses(wheelset: ReducedWheelset) -> None:
    """But for what rang at the start; the simulation lets modes of 5e-4 of the static stress answer at once."""
    block = Simulator(load_scenario("damage_wheel_1")).advance(40000)
    found = stresses_from_forces(wheelset, block.forces, block.step_period, block.nodes)
    largest = np.abs(block.stresses).max()
    error = np.abs(found - block.stresses).max(axis=(1, 2)) / largest
    assert error[:2000].max() < 2e-2
    assert error[30000:].max() < 5e-4
    assert np.array_equal(found[:, :, 3] == 0, block.stresses[:, :, 3] == 0)  # what is zero by symmetry


def test_nodes_are_chosen_by_name(wheelset: ReducedWheelset) -> None:
    forces = 1e5 + 1e3 * np.random.default_rng(1).standard_normal((100, 2))
    every = stresses_from_forces(wheelset, forces, 3e-5)
    some = stresses_from_forces(wheelset, forces, 3e-5, ["C1", "A1"])
    np.testing.assert_allclose(some, every[:, [wheelset.node("C1"), wheelset.node("A1")]], atol=1e-3)


@pytest.mark.slow
def test_a_finer_record_of_the_same_forces_gives_the_same_stress(wheelset: ReducedWheelset) -> None:
    time = np.arange(40000) * 2.5e-5
    push = 1e5 + 8e4 * np.exp(-(((time - 0.3) / 2e-3) ** 2))
    forces = np.stack([push, np.full_like(push, 1e5)], axis=-1)
    fine = stresses_from_forces(wheelset, forces, 2.5e-5)
    coarse = stresses_from_forces(wheelset, forces[::16], 16 * 2.5e-5)
    assert np.abs(coarse - fine[::16]).max() < 1e-3 * np.abs(fine).max()


def test_what_cannot_be_used_is_refused(wheelset: ReducedWheelset) -> None:
    with pytest.raises(InputError, match="not finite"):
        stresses_from_forces(wheelset, np.array([[1e5, np.nan]]), 1e-4)
    with pytest.raises(InputError, match="Z9"):
        stresses_from_forces(wheelset, np.ones((20, 2)), 1e-4, ["Z9"])
