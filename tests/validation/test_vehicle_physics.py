"""A wheelset under a vehicle against finite elements with that vehicle, its masses alone, and the linear response."""

import dataclasses
import warnings

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from wheelset_track_sim.errors import InputWarning
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wheelset import stress_points
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress
from wheelset_track_sim.wheelset.harmonics import HARMONICS, harmonic
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduction import reduced_wheelset
from wheelset_track_sim.wheelset.vehicle import Vehicle, load_vehicle
from wheelset_track_sim.wheelset.wheelset import Wheelset

FRAME = load_vehicle("power_car")
BODY = load_scenario("long_wave").vehicle


def solved(wheelset: Wheelset, vehicle: Vehicle, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """Receptance (2, 2) and stress over force (N, 6, 2) of the finite elements with a vehicle, without any modes."""
    mesh, omega, material = wheelset_mesh(wheelset), 2 * np.pi * frequency, wheelset.material
    samples = stress_points.stress_points(wheelset, mesh)
    spring, dashpot = wheelset.axle_boxes.stiffness, wheelset.axle_boxes.damping
    M, C, K = (np.kron(side, np.eye(2)) for side in vehicle.matrices(spring, dashpot))
    receptance, stress, static = np.zeros((2, 2), complex), 0.0, 0.0
    for n in HARMONICS:
        model = harmonic(wheelset, mesh, n)
        damping = material.mass_damping * model.mass + material.stiffness_damping * model.stiffness
        dynamic = model.stiffness - omega**2 * model.mass + 1j * omega * damping
        loads, size = model.contacts.astype(complex), len(model.contacts)
        if n == 1:
            boxes = sp.csc_array(model.boxes)
            link = sp.csc_array(
                np.hstack([-(spring + 1j * omega * dashpot) * model.boxes, np.zeros((size, len(M) - 2))])
            )
            above = sp.csc_array(K - omega**2 * M + 1j * omega * C)
            dynamic = sp.block_array([[dynamic + 1j * omega * dashpot * (boxes @ boxes.T), link], [link.T, above]])
            loads = np.vstack([loads, np.zeros((len(M), 2))])
        u = splu(dynamic.tocsc()).solve(loads)[:size]
        receptance += model.contacts.T @ u
        to_stress = samples.turned(n) @ nodal_stress(mesh, material, n, samples.nodes) @ model.free
        stress = stress + (to_stress @ u).reshape(-1, 6, 2)
        static = static + (to_stress @ model.static(model.contacts)).reshape(-1, 6, 2)
    return receptance, stress_points.combined(stress, samples.picks(static.sum(axis=2)))


@pytest.mark.slow
@pytest.mark.parametrize(("vehicle", "frequency"), [(FRAME, 5.0), (BODY, 1.39), (BODY, 85.0)])
def test_modes_answer_as_finite_elements_with_the_vehicle(vehicle: Vehicle, frequency: float) -> None:
    x40 = load_wheelset("x40")
    reduced = reduced_wheelset(x40, vehicle=vehicle)
    receptance, stress = solved(x40, vehicle, frequency)
    found = reduced.receptance(np.array([frequency]))[0] + reduced.displacement_residual
    assert found == pytest.approx(receptance, abs=1e-4 * np.abs(receptance).max())
    found = reduced.stress_receptance(np.array([frequency]))[0]
    assert found == pytest.approx(stress, abs=3e-4 * np.abs(stress).max())


@pytest.mark.parametrize("vehicle", [FRAME, BODY, load_vehicle("coach")])
def test_below_the_bending_of_the_axle_it_is_a_chain_of_masses(vehicle: Vehicle) -> None:
    """Both wheels loaded alike; how the axle bends at 0 Hz is added, which errs with the square of the frequency."""
    trailer = load_wheelset("trailer")
    reduced, fixed = reduced_wheelset(trailer, vehicle=vehicle), reduced_wheelset(trailer)
    k1, c1 = trailer.axle_boxes.stiffness, trailer.axle_boxes.damping
    bending = fixed.static_receptance().sum(axis=1).mean() - 1 / k1
    frequencies = np.array([0.3, 0.7, 1.39, 2.0, 3.0, 5.0])
    expected = []
    for s in 2j * np.pi * frequencies:
        M, C, K = vehicle.matrices(k1, c1)
        above = 1 / np.linalg.inv(K + s * C + s**2 * M)[0, 0] - (k1 + s * c1)  # what frame and body resist with
        on_boxes = 1 / (1 / (k1 + s * c1) + 1 / above)
        expected.append(1 / (on_boxes + s**2 * reduced.mass / 2) + bending)
    found = reduced.receptance(frequencies).sum(axis=2).mean(axis=1)
    assert (np.abs(found / expected - 1) < 6e-4 * frequencies**2).all()


@pytest.mark.slow
@pytest.mark.parametrize(("vehicle", "amplitude"), [(None, 18.7e3), (FRAME, 2.66e3), (BODY, 9.06e3)])
def test_a_wave_of_20_m_makes_the_force_of_the_linear_response(vehicle: Vehicle | None, amplitude: float) -> None:
    scenario = dataclasses.replace(load_scenario("long_wave", ["step_length=0.002"]), vehicle=vehicle)
    simulator = quiet(scenario)
    length = 10_000  # steps of a wave
    block = simulator.advance(3 * length)
    waves = np.exp(-2j * np.pi * np.arange(3 * length) / length)
    found = 2 * np.abs(np.mean((block.forces[:, 0] - block.forces[:, 0].mean()) * waves))
    reduced, frequency = simulator.models.reduced, np.array([scenario.speed / 20])
    track = simulator.models.dynamics.track.symmetric.compliance().mean()
    linear = 0.010 / np.abs(reduced.receptance(frequency)[0].sum(axis=1)[0] + track + 1e-9)
    assert found == pytest.approx(linear, rel=0.01)
    assert found == pytest.approx(amplitude, rel=0.01)
    assert block.forces.mean() == pytest.approx(scenario.wheel_load, rel=1e-3)


@pytest.mark.slow
def test_the_load_follows_over_a_soft_stretch() -> None:
    """The rail gives way 0.6 mm more there than in the mean: 1.2 kN on held springs."""
    change = "track={base: ballasted_60e1, line: {bays: 200, supports: [{sleepers: 60-140, ballast_stiffness: 0.3}]}}"
    lost = []
    for vehicle in (None, FRAME, BODY):
        scenario = dataclasses.replace(load_scenario("undamaged", [change]), vehicle=vehicle)
        simulator = quiet(scenario)
        simulator.advance(48_000)
        forces = np.concatenate([simulator.advance(6_000).forces for _ in range(4)])  # sleepers 80 to 120
        lost.append(scenario.wheel_load - forces.mean())
    assert lost[0] > 1e3
    assert lost[0] / lost[1] == pytest.approx(1 + 2.0e6 / 442900.0, rel=0.1)
    assert abs(lost[2]) < 0.1 * lost[0]


def quiet(scenario: Scenario) -> Simulator:
    """A settled simulator, without the warnings that the case is about."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        simulator = Simulator(scenario)
    simulator.settle()
    return simulator
