import numpy as np
import pytest
from scipy.linalg import eigh, expm

from wheelset_track_sim.track.timoshenko import (
    deflection_row,
    element_matrices,
    local_flexibility,
    shape_functions,
    transfer_matrix,
)
from wheelset_track_sim.track.track import load_track

RAIL = load_track("ballasted_60e1").rail
L = 0.6


def test_one_element_bends_and_shears_as_a_cantilever_does() -> None:
    stiffness, _ = element_matrices(RAIL, L)
    w, theta = np.linalg.solve(stiffness[2:, 2:], [1.0, 0.0])
    assert w == pytest.approx(L**3 / (3 * RAIL.EI) + L / RAIL.kGA, rel=1e-12)
    assert theta == pytest.approx(L**2 / (2 * RAIL.EI), rel=1e-12)


def test_rigid_motion_is_free_and_moves_the_right_mass() -> None:
    stiffness, mass = element_matrices(RAIL, L)
    heave, turn = np.array([1.0, 0.0, 1.0, 0.0]), np.array([-L / 2, 1.0, L / 2, 1.0])
    np.testing.assert_allclose(stiffness @ np.stack([heave, turn], axis=1), 0.0, atol=1e-9 * stiffness.max())
    assert heave @ mass @ heave == pytest.approx(RAIL.rhoA * L, rel=1e-12)
    assert turn @ mass @ turn == pytest.approx(RAIL.rhoA * L**3 / 12 + RAIL.rhoI * L, rel=1e-12)


def test_shape_functions_are_in_static_equilibrium() -> None:
    """Shear force constant and equal to minus the slope of the moment, for any end displacements."""
    s = np.linspace(0.0, 1.0, 201)
    w, theta = shape_functions(RAIL, L, s)
    h = (s[1] - s[0]) * L
    shear = RAIL.kGA * (np.gradient(w, h, axis=0, edge_order=2) - theta)[1:-1]
    moment_slope = RAIL.EI * (theta[2:] - 2 * theta[1:-1] + theta[:-2]) / h**2
    np.testing.assert_allclose(shear, -moment_slope, atol=2e-3 * np.abs(moment_slope).max())
    np.testing.assert_allclose(shear - shear[0], 0.0, atol=2e-3 * np.abs(shear).max())


def test_load_inside_a_clamped_element() -> None:
    middle = local_flexibility(RAIL, L, np.array(L / 2), np.array(L / 2))
    assert middle == pytest.approx(L**3 / (192 * RAIL.EI) + L / (4 * RAIL.kGA), rel=1e-12)
    x = np.linspace(0.0, L, 13)
    table = local_flexibility(RAIL, L, x[:, None], x)
    np.testing.assert_allclose(table, table.T, atol=1e-15 * table.max())
    np.testing.assert_allclose(table[[0, -1]], 0.0, atol=1e-12 * table.max())


@pytest.mark.parametrize("frequency", [0.0, 75.0, 1073.0, 5000.0, 10000.0])
def test_transfer_matrix_is_the_exponential_of_the_beam_equations(frequency: float) -> None:
    omega_2 = (2 * np.pi * frequency) ** 2
    a = np.array(
        [
            [0.0, 1.0, 1.0 / RAIL.kGA, 0.0],
            [0.0, 0.0, 0.0, 1.0 / RAIL.EI],
            [-RAIL.rhoA * omega_2, 0.0, 0.0, 0.0],
            [0.0, -RAIL.rhoI * omega_2, -1.0, 0.0],
        ]
    )
    omega = np.array([2 * np.pi * frequency])
    T = transfer_matrix(RAIL, omega, L)[0]
    expected = expm(a * L)
    scale = np.array([1.0, 1.0, RAIL.kGA, RAIL.EI])
    size = np.abs(expected * scale / scale[:, None]).max()
    digits = 1e-10 if frequency <= 5000.0 else 1e-6
    error = np.abs((T - expected) * scale / scale[:, None]).max()
    assert error < digits * size
    np.testing.assert_allclose(deflection_row(RAIL, omega, L)[0], T[0], rtol=1e-12)


def test_pinned_beam_converges_to_its_closed_form_as_the_docs_say() -> None:
    """Pinned-pinned over one bay: omega^2 is too high by rhoA omega^2 h^2 / (12 kGA), 0.51 % with 8 elements."""
    k_2 = (np.pi / L) ** 2
    a = RAIL.rhoA * RAIL.rhoI
    b = -(RAIL.rhoA * RAIL.kGA + k_2 * (RAIL.rhoA * RAIL.EI + RAIL.rhoI * RAIL.kGA))
    c = RAIL.EI * RAIL.kGA * k_2**2
    exact = (-b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)
    for count in (8, 16, 32):
        k, m = element_matrices(RAIL, L / count)
        stiffness, mass = np.zeros((2, 2 * count + 2, 2 * count + 2))
        for element in range(count):
            at = slice(2 * element, 2 * element + 4)
            stiffness[at, at] += k
            mass[at, at] += m
        free = np.delete(np.arange(2 * count + 2), [0, 2 * count])
        lowest = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)[0]
        predicted = RAIL.rhoA * exact * (L / count) ** 2 / (12 * RAIL.kGA)
        assert lowest / exact - 1 == pytest.approx(predicted, rel=0.05)
    assert np.sqrt(exact) / (2 * np.pi) == pytest.approx(1073, abs=2)
