"""The X40 against what the paper says of it, and the reduction against the finite elements it comes from."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import scipy
from scipy.sparse.linalg import spsolve

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress
from wheelset_track_sim.wheelset.harmonics import HARMONICS, harmonic
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset, diagonalised, mode_shapes, reduced_wheelset
from wheelset_track_sim.wheelset.stress_points import around_axle
from wheelset_track_sim.wheelset.wheelset import Wheelset

WHEEL_LOAD = 98.1e3  # N


def bending_frequency(reduced: ReducedWheelset) -> float:
    """Natural frequency nearest to the paper's 206 Hz."""
    return float(reduced.frequencies[np.abs(reduced.frequencies - 206.0).argmin()])


def static_principal(reduced: ReducedWheelset) -> np.ndarray:
    """Maximum principal stress at each node under the static load on both wheels, MPa."""
    return maximum_principal(reduced.static_stress().sum(axis=2) * WHEEL_LOAD) / 1e6


def test_mass(reduced_x40: ReducedWheelset) -> None:
    assert reduced_x40.mass == pytest.approx(1943.0, rel=0.002)


def test_modes_on_the_suspension(x40: Wheelset, reduced_x40: ReducedWheelset) -> None:
    """Bounce and roll against a rigid wheelset of the same mass and inertia on two springs and dashpots."""
    assert reduced_x40.frequencies[:2] == pytest.approx([7.2, 9.6], abs=0.05)
    mesh = wheelset_mesh(x40)
    model = harmonic(x40, mesh, 1)
    y, r = mesh.points.T
    lift, roll = np.stack([0 * y + 1, 0 * y, 0 * y - 1], axis=1), np.stack([y, -r, -y], axis=1)
    rigid = (model.free.T @ np.stack([lift.ravel(), roll.ravel()], axis=1)) / (model.free.T @ model.free).diagonal()[
        :, None
    ]
    mass = rigid.T @ model.mass @ rigid
    assert mass[0, 0] == pytest.approx(reduced_x40.mass, rel=1e-9)
    arms = np.array([[1.0, 1.0], [-1.0275, 1.0275]])
    unit = np.linalg.solve(mass, arms @ arms.T)
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-2e6 * unit, -20e3 * unit]])
    poles = np.linalg.eigvals(system)
    expected = np.sort_complex(poles[poles.imag > 0])[::-1]
    assert reduced_x40.poles[:2] == pytest.approx(expected, rel=0.01)


def test_bending_mode_at_206_hz(reduced_x40: ReducedWheelset) -> None:
    assert bending_frequency(reduced_x40) == pytest.approx(206.0, rel=0.01)


def test_strong_mode_of_a1_at_1920_hz(reduced_x40: ReducedWheelset) -> None:
    """Fig. 5: by a force on wheel 1, the highest peak of the axial stress at A1 between 1 and 2.5 kHz."""
    frequencies = np.arange(1000.0, 2500.0, 0.5)
    stress = np.abs(reduced_x40.stress_receptance(frequencies)[:, reduced_x40.node("A1"), 1, 0])
    peaks, _ = scipy.signal.find_peaks(stress)
    highest = frequencies[peaks[stress[peaks].argmax()]]
    assert highest == pytest.approx(1920.0, rel=0.02)


def test_static_stresses(reduced_x40: ReducedWheelset) -> None:
    assert reduced_x40.node_names == ("A1", "B1", "C1")
    assert static_principal(reduced_x40) == pytest.approx([66.0, 63.0, 60.0], rel=0.02)
    # Beam theory, without the notch: the couple of wheel and axle box over the section modulus.
    bending = WHEEL_LOAD * (1.0275 - 0.750) / (np.pi * 0.180**3 / 32) / 1e6
    assert bending < static_principal(reduced_x40)[0] < 1.5 * bending


def test_stress_nodes_are_at_the_top_on_their_fillets(reduced_x40: ReducedWheelset) -> None:
    x, y, z = reduced_x40.node_positions.T
    assert (x == 0).all()
    assert (z > 0.09).all()
    assert -0.645 < y[0] < -0.6239
    assert 0.2755 - 0.0272 < y[1] < 0.2755
    assert 0.6276 < y[2] < 0.645


@pytest.mark.slow
def test_reduced_statics_are_those_of_the_finite_elements(x40: Wheelset, reduced_x40: ReducedWheelset) -> None:
    mesh = wheelset_mesh(x40)
    nodes = mesh.nodes_on(reduced_x40.node_positions[:, 1:])
    stress, displacement = np.zeros((len(nodes), 6, 2)), np.zeros((2, 2))
    for n in HARMONICS:
        model = harmonic(x40, mesh, n)
        stiffness = model.stiffness
        if n == 0:  # hold the axial motion of the last node instead of the first unknown
            stiffness = stiffness.tolil()
            stiffness[-1, -1] += 1e12
        static = model.free @ spsolve(stiffness.tocsc(), model.contacts)
        amplitudes = (nodal_stress(mesh, x40.material, n, nodes) @ static).reshape(len(nodes), 6, 2)
        stress += np.einsum("ij,njw->niw", around_axle(n, 0.0), amplitudes)
        displacement += (model.free @ model.contacts).T @ static
    found = reduced_x40.static_stress()
    assert found == pytest.approx(stress, abs=1e-3 * np.abs(stress).max() / 10)
    assert static_principal(reduced_x40) == pytest.approx(
        maximum_principal(stress.sum(axis=2) * WHEEL_LOAD) / 1e6, rel=1e-3
    )
    complete = reduced_x40.static_receptance() + reduced_x40.displacement_residual
    assert complete == pytest.approx(displacement, rel=1e-3)
    # The modes to 6 kHz carry nearly all of the stress: the residual is a correction.
    assert np.abs(reduced_x40.stress_feedthrough).max() < 0.01 * np.abs(found).max()


def test_reciprocity(reduced_x40: ReducedWheelset) -> None:
    receptance = reduced_x40.receptance(np.arange(0.0, 6000.0, 5.0))
    assert np.abs(receptance[:, 0, 1] - receptance[:, 1, 0]).max() < 1e-10 * np.abs(receptance[:, 0, 1]).max()
    # The gearbox makes the wheels differ.
    assert np.abs(receptance[:, 0, 0] - receptance[:, 1, 1]).max() > 0.01 * np.abs(receptance).max()


def test_passive(reduced_x40: ReducedWheelset) -> None:
    """A force never draws work from the wheelset: the imaginary part of the receptance matrix is negative definite."""
    imaginary = reduced_x40.receptance(np.geomspace(0.1, 6000.0, 4000)).imag
    assert np.linalg.eigvalsh((imaginary + imaginary.transpose(0, 2, 1)) / 2).max() < 0


def test_signs(reduced_x40: ReducedWheelset) -> None:
    """Slowly, a contact force lifts its wheel and bends the axle so that its top is in tension."""
    assert (reduced_x40.static_receptance() > 0).all()
    assert (reduced_x40.static_stress()[:, 1] > 0).all()
    # Far above the suspension and below the first bending mode the force pushes a mass away.
    assert reduced_x40.receptance(np.array([30.0]))[0, 0, 0].real < 0


def test_diagonalised_full_damping() -> None:
    """Overdamped, coupled and lightly damped modes at once, against a direct solution at some frequencies."""
    rng = np.random.default_rng(1)
    omega = np.array([10.0, 50.0, 60.0, 200.0])
    shape = rng.standard_normal((4, 2))
    damping = np.diag([100.0, 0.1, 0.1, 0.2]) + 5.0 * shape @ shape.T
    poles, left, right = diagonalised(omega, damping)
    assert (poles.imag == 0).sum() == 2
    assert len(poles) == 5
    for w in (0.0, 9.0, 55.0, 300.0):
        direct = np.linalg.inv(np.diag(omega**2 - w**2) + 1j * w * damping)
        modal = (right / (1j * w - poles)) @ left / 2 + (right.conj() / (1j * w - poles.conj())) @ left.conj() / 2
        assert modal == pytest.approx(direct, rel=1e-9, abs=1e-12)


def test_stress_directions_at_the_top() -> None:
    """A stress that is the same everywhere, z z (n = 0 and 2 in polar components), comes out as such."""
    uniform = {0: [0.5, 0, 0.5, 0, 0, 0], 2: [0.5, 0, -0.5, 0, -0.5, 0]}
    found = sum(around_axle(n, 0.0) @ np.array(amplitudes) for n, amplitudes in uniform.items())
    assert found == pytest.approx([0, 0, 1, 0, 0, 0])
    # y z shear: along theta = 0 (downwards) it is -1, n = 1.
    assert around_axle(1, 0.0) @ np.array([0, 0, 0, -1.0, 0, 1.0]) == pytest.approx([0, 0, 0, 0, 0, 1])


@pytest.mark.slow
def test_stored_under_a_digest(x40: Wheelset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path))
    coarse = replace(x40, mesh=x40.mesh.divided(0.5))
    stages: list[tuple[str, float]] = []
    built = reduced_wheelset(coarse, max_frequency=600.0, progress=lambda stage, part: stages.append((stage, part)))
    assert [part for _, part in stages] == sorted(part for _, part in stages)
    assert stages[-1][1] == 1.0
    stages.clear()
    again = reduced_wheelset(coarse, max_frequency=600.0, progress=lambda stage, part: stages.append((stage, part)))
    assert not stages
    for field in fields(ReducedWheelset):
        assert np.array_equal(getattr(built, field.name), getattr(again, field.name))
    reduced_wheelset(replace(coarse, gearbox=None), max_frequency=600.0)
    assert len(list(tmp_path.glob("wheelset-*.npz"))) == 2


@pytest.mark.slow
def test_same_model_twice(x40: Wheelset) -> None:
    coarse = replace(x40, mesh=x40.mesh.divided(0.5))
    one, two = (build_reduced_wheelset(coarse, max_frequency=600.0) for _ in range(2))
    assert np.array_equal(one.poles, two.poles)
    assert np.array_equal(one.stress_outputs, two.stress_outputs)


@pytest.mark.slow
def test_without_stress_nodes(x40: Wheelset) -> None:
    bare = build_reduced_wheelset(replace(x40, mesh=x40.mesh.divided(0.5), stress_nodes=()), max_frequency=600.0)
    assert bare.stress_outputs.shape == (0, 6, len(bare.poles))


@pytest.mark.slow
def test_mode_shapes(x40: Wheelset) -> None:
    mesh, shapes = mode_shapes(x40, 500.0)
    assert [found.n for found in shapes] == list(HARMONICS)
    bending = shapes[1]
    assert bending.frequencies[3] == pytest.approx(206.0, rel=0.01)
    assert bending.shapes.shape == (len(bending.frequencies), len(mesh.points), 3)
    # Second bending of the axle: its line crosses zero between the wheels once, near the middle.
    axis = np.flatnonzero((mesh.points[:, 1] == 0) & (np.abs(mesh.points[:, 0]) < 0.75))
    line = bending.shapes[3][axis[np.argsort(mesh.points[axis, 0])], 0]
    assert (np.diff(np.sign(line)) != 0).sum() == 1


@pytest.mark.slow
def test_halving_the_mesh(x40: Wheelset, reduced_x40: ReducedWheelset) -> None:
    fine = build_reduced_wheelset(replace(x40, mesh=x40.mesh.divided(2)), max_frequency=500.0)
    assert static_principal(fine) == pytest.approx(static_principal(reduced_x40), rel=0.01)
    assert bending_frequency(fine) == pytest.approx(bending_frequency(reduced_x40), rel=0.005)
