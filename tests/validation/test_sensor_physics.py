"""Sensors on the wheelset against closed forms, direct solutions and differences of each other."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from support.toy import toy_simulator
from wheelset_track_sim.sensors.kinds import StrainGauge
from wheelset_track_sim.wheelset.harmonics import harmonic
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.sensor_rows import AxialStrain, BoxMotion, PointMotion, SuspensionReaction, strain_rows
from wheelset_track_sim.wheelset.vehicle import Vehicle

BAND = 700.0
Y = 0.05  # between gearbox and wheel 1, on the body of 180 mm
MOTIONS = tuple(BoxMotion(wheel, order) for wheel in (0, 1) for order in range(3))
ROWS = (*MOTIONS, SuspensionReaction(0), SuspensionReaction(1), AxialStrain(Y, None), AxialStrain(Y, None, pi / 3))
POINT = PointMotion(0.0, 0.09, 0.7, 2)
STIFF = {"bearing_stiffness": 1e9, "bearing_damping": 2e4}
FRAME = Vehicle(bogie_mass=1500.0, secondary_stiffness=3e5, secondary_damping=2e4)


@pytest.fixture(scope="module")
def coarse():
    x40 = load_wheelset("x40")
    return replace(x40, mesh=x40.mesh.divided(0.4), stress_nodes=())


@pytest.fixture(scope="module")
def reduced(coarse):
    return build_reduced_wheelset(coarse, BAND, None, (*ROWS, *strain_rows(Y), POINT))


@pytest.fixture(scope="module")
def on_bearings(coarse):
    return replace(coarse, axle_boxes=replace(coarse.axle_boxes, **STIFF))


def sensed(reduced, frequencies):
    """Responses (frequencies, rows, 2) to a unit force on each wheel."""
    return reduced._response(reduced.sensor_outputs, np.array(frequencies)) + reduced.sensor_feedthrough


def direct(wheelset, frequency):
    """Displacement of both contacts under a force of 1 N on each axle box: (contacts, boxes), without modes."""
    model = harmonic(wheelset, wheelset_mesh(wheelset), 1)
    s, material, boxes = 2j * pi * frequency, wheelset.material, wheelset.axle_boxes
    damping = material.mass_damping * model.mass + material.stiffness_damping * model.stiffness
    dynamic = model.stiffness + s * damping + s**2 * model.mass
    for dashpot, lift in ((boxes.damping, model.boxes), (boxes.bearing_damping or 0.0, model.bearings)):
        dynamic = dynamic + s * dashpot * sp.csc_array(lift) @ sp.csc_array(lift).T
    return model.contacts.T @ splu(dynamic.tocsc()).solve(model.boxes.astype(np.complex128))


def test_velocity_and_acceleration_are_the_rates_of_displacement(reduced):
    frequencies = np.array([3.0, 40.0, 300.0, 600.0])
    s = 2j * pi * frequencies[:, np.newaxis]
    displacement, velocity, acceleration = (sensed(reduced, frequencies)[:, order] for order in range(3))
    assert velocity == pytest.approx(s * displacement, rel=1e-9)
    assert acceleration == pytest.approx(s**2 * displacement, rel=1e-8)
    assert np.abs(reduced.sensor_feedthrough[[0, 1, 3, 4]]).max() == 0.0  # a force moves nothing at once


@pytest.mark.slow
@pytest.mark.parametrize("name", ["coarse", "on_bearings"])
def test_a_box_answers_a_wheel_as_the_wheel_answers_the_box(name, request):
    """Reciprocity: the direct solution of the finite elements under forces on the boxes has no modes and no sensors."""
    wheelset = request.getfixturevalue(name)
    found = build_reduced_wheelset(wheelset, BAND, None, (BoxMotion(0, 0), BoxMotion(1, 0)))
    for frequency in (5.0, 120.0):
        assert sensed(found, [frequency])[0] == pytest.approx(
            direct(wheelset, frequency).T, rel=0.02, abs=8e-12
        )  # modes above


@pytest.mark.slow
def test_a_stiff_wheelset_moves_as_a_rigid_body_on_its_springs(coarse):
    stiff = replace(coarse, material=replace(coarse.material, youngs_modulus=1e12))
    found = build_reduced_wheelset(stiff, BAND, None, (BoxMotion(0, 2), BoxMotion(1, 2)))
    s, boxes = 2j * pi * 12.0, stiff.axle_boxes
    expected = s**2 / (found.mass * s**2 + 2 * boxes.damping * s + 2 * boxes.stiffness)
    assert sensed(found, [12.0])[0].mean(axis=0).sum() == pytest.approx(2 * expected, rel=0.01)


def test_a_standing_load_rests_on_the_springs(coarse, reduced):
    found = sensed(reduced, [0.0])[0].real
    assert found[[1, 2, 4, 5]] == pytest.approx(np.zeros((4, 2)), abs=1e-9)
    forces = found[6:8]
    assert forces.sum(axis=0) == pytest.approx(np.ones(2), rel=1e-5)
    boxes, wheels = coarse.axle_boxes.distance, np.array(coarse.contact_positions)
    assert boxes * (forces[1] - forces[0]) == pytest.approx(wheels, rel=1e-4)
    assert found[[0, 3]] * coarse.axle_boxes.stiffness == pytest.approx(forces, rel=1e-9)


@pytest.mark.slow
def test_bearings_take_the_load_too_and_boxes_ring_on_them(on_bearings):
    rows = (SuspensionReaction(0), SuspensionReaction(1), BoxMotion(0, 2))
    soft = build_reduced_wheelset(on_bearings, BAND, None, rows)
    assert sensed(soft, [0.0])[0, :2].real.sum(axis=0) == pytest.approx(np.ones(2), rel=1e-5)
    free = np.sqrt(STIFF["bearing_stiffness"] / on_bearings.axle_boxes.mass) / (2 * pi)
    frequencies = np.arange(100.0, 700.0, 2.0)
    boxes = np.abs(sensed(soft, frequencies)[:, 2].sum(axis=1))
    assert free == pytest.approx(349.0, abs=1.0)
    far = frequencies > 2.5 * free / np.sqrt(2)  # above its resonance the box is isolated from the journal
    assert boxes[far].max() < 0.5 * boxes.max()


@pytest.mark.slow
def test_the_frame_takes_what_the_suspension_gives(coarse):
    rows = (SuspensionReaction(0), SuspensionReaction(1), BoxMotion(0, 0), BoxMotion(1, 0))
    found = build_reduced_wheelset(coarse, BAND, FRAME, rows)
    frequency = 4.0
    s, k, c = 2j * pi * frequency, coarse.axle_boxes.stiffness, coarse.axle_boxes.damping
    lift = sensed(found, [frequency])[0, 2:]
    upper = FRAME.bogie_mass * s**2 + FRAME.secondary_damping * s + FRAME.secondary_stiffness
    expected = (k + c * s) * lift * upper / (upper + k + c * s)
    assert sensed(found, [frequency])[0, :2] == pytest.approx(expected, rel=1e-6)


def test_strain_is_that_of_beam_bending(coarse, reduced):
    load, radius = 98.1e3, 0.090
    moment = load * (coarse.axle_boxes.distance - coarse.wheel.contact)
    expected = moment * radius / (pi / 4 * radius**4) / coarse.material.youngs_modulus
    found = load * sensed(reduced, [0.0])[0].real.sum(axis=1)
    assert found[8] == pytest.approx(expected, rel=0.01)
    assert found[9] == pytest.approx(expected * np.cos(pi / 3), rel=0.02)


def test_a_gauge_that_turns_reads_rotating_bending(coarse, reduced):
    """Under a standing load it swings between tension and compression once a turn."""
    gauge = StrainGauge(name="g", y=Y, angle=0.3)
    angles = np.linspace(0.0, 4 * pi, 400)
    amplitudes = 98.1e3 * sensed(reduced, [0.0])[0, 10:17].real.sum(axis=1)
    strain = gauge.signals(np.tile(amplitudes, (400, 1)), angles)[:, 0]
    moment = 98.1e3 * (coarse.axle_boxes.distance - coarse.wheel.contact)
    expected = moment / (pi / 4 * 0.090**3) / coarse.material.youngs_modulus
    assert strain == pytest.approx(expected * np.cos(0.3 + angles), abs=0.01 * expected)
    still = sensed(reduced, [100.0])[0, 9], sensed(reduced, [100.0])[0, 10:17]
    turned = gauge.signals(still[1].real.T, np.full(2, pi / 3 - 0.3))[:, 0]
    assert turned == pytest.approx(still[0].real, rel=1e-9)  # as it passes a fixed gauge it reads the same


def test_a_place_on_the_axle_moves_as_the_beam(reduced):
    """A point of the section moves up with it, wherever it is around the axle."""
    low = sensed(reduced, [20.0])[0]
    assert low[17].sum() == pytest.approx(low[2].sum(), rel=0.15)  # bending begins at 85 Hz


def spectrum(signal, dt):
    """Spectrum of a signal (n,) under a Hann window, and frequencies."""
    return np.fft.rfft(signal * np.hanning(len(signal))), np.fft.rfftfreq(len(signal), dt)


def test_acceleration_is_the_second_difference_of_displacement():
    sensors = [{"type": kind, "name": "m", "at": "middle"} for kind in ("displacement", "velocity", "acceleration")]
    simulator = toy_simulator(like="damage_wheel_1", sensors=sensors)
    block = simulator.advance(4 * 2713)
    x, v, a = (block.sensors[f"{kind['type']}/m"][:, 0] for kind in sensors)
    dt = block.step_period
    found, f = spectrum(a[1:-1], dt)
    turn = 2 * pi * f * dt
    with np.errstate(invalid="ignore"):
        second = spectrum(np.diff(x, 2) / dt**2, dt)[0] * turn**2 / (2 - 2 * np.cos(turn))
        first = spectrum((x[2:] - x[:-2]) / (2 * dt), dt)[0] * turn / np.sin(turn)
    band = (f > 5.0) & (f < 0.2 / dt)
    assert np.linalg.norm((second - found)[band]) < 0.02 * np.linalg.norm(found[band])
    assert np.linalg.norm((first - spectrum(v[1:-1], dt)[0])[band]) < 0.02 * np.linalg.norm(spectrum(v, dt)[0])
