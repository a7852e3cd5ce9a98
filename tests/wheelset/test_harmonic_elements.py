"""Patch tests: fields that the elements must reproduce exactly, with stresses from the elasticity of the solid."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from wheelset_track_sim.wheelset.harmonic_elements import free_unknowns, nodal_stress, solid_mass, stiffness_and_mass
from wheelset_track_sim.wheelset.parts import Material
from wheelset_track_sim.wheelset.section_mesh import SectionMesh, divided, grid, joined

STEEL = Material(density=7810.0, youngs_modulus=210e9, poissons_ratio=0.3, mass_damping=0.0, stiffness_damping=0.0)
E, NU = STEEL.youngs_modulus, STEEL.poissons_ratio
G = E / (2 * (1 + NU))


def cylinder(bore: float, skew: float) -> SectionMesh:
    y, r = divided([0.0, 0.4], 0.1), divided([bore, 0.1], 0.03)
    return joined([grid(y[:, None] + skew * (r[None, :] - bore), r[None, :] + 0 * y[:, None])])


def axial_and_radial(y: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    return r * 1e-4, y * 2e-4, 0 * r


def plane_shear(y: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    return r * 1e-4, 0 * r, -r * 1e-4


def bending(y: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    """Saint-Venant bending with curvature 1e-3 1/m: u_y = k y x and what Poisson's ratio makes of the section."""
    k = 1e-3
    return -k / 2 * (y**2 + NU * r**2), k * y * r, k / 2 * (y**2 - NU * r**2)


@pytest.mark.parametrize(
    ("n", "field", "skew", "stress"),
    [
        (0, axial_and_radial, 0.3, lambda r: _lame(1e-4, 2e-4, 1e-4)),
        (2, plane_shear, 0.3, lambda r: [2e-4 * G, 0, -2e-4 * G, 0, -2e-4 * G, 0]),
        (1, bending, 0.0, lambda r: [0, E * 1e-3 * r, 0, 0, 0, 0]),
    ],
)
@pytest.mark.parametrize("bore", [0.0, 0.02])
def test_patch(n: int, field: object, skew: float, stress: object, bore: float) -> None:
    mesh = cylinder(bore, skew)
    y, r = mesh.points.T
    exact = np.stack(field(y, r), axis=1).ravel()  # type: ignore[operator]
    stiffness, _ = stiffness_and_mass(mesh, STEEL, n)
    free = free_unknowns(mesh, n)
    # Displacements given on the boundary, equilibrium inside.
    inside = np.repeat((y > 0.001 + skew * (r - bore)) & (y < 0.399 + skew * (r - bore)) & (r < 0.0999), 3)
    if bore:
        inside &= np.repeat(r > bore + 1e-4, 3)
    inner = (free.T @ inside.astype(float)) != 0
    kept = free[:, np.flatnonzero(inner)]
    given = exact - kept @ _restriction(kept, exact)
    found = kept @ spsolve((kept.T @ stiffness @ kept).tocsc(), -kept.T @ (stiffness @ given)) + given
    assert found == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())

    nodes = np.flatnonzero(r > 0.01)
    values = (nodal_stress(mesh, STEEL, n, nodes) @ found).reshape(-1, 6)
    expected = np.array([stress(radius) for radius in r[nodes]])  # type: ignore[operator]
    assert values == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def _lame(rr: float, yy: float, tt: float) -> list[float]:
    first = E * NU / ((1 + NU) * (1 - 2 * NU)) * (rr + yy + tt)
    return [first + 2 * G * rr, first + 2 * G * yy, first + 2 * G * tt, 0.0, 0.0, 0.0]


def _restriction(kept: sp.csc_array, exact: np.ndarray) -> np.ndarray:
    return (kept.T @ exact) / np.asarray(kept.power(2).sum(axis=0)).ravel()


def test_mass_of_a_tube() -> None:
    mesh = cylinder(0.02, 0.3)
    volume = np.pi * (0.1**2 - 0.02**2) * 0.4
    assert solid_mass(mesh, STEEL) == pytest.approx(STEEL.density * volume, rel=1e-12)
    _, mass = stiffness_and_mass(mesh, STEEL, 1)
    sideways = np.tile([1.0, 0.0, -1.0], len(mesh.points))
    assert sideways @ mass @ sideways == pytest.approx(STEEL.density * volume, rel=1e-12)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_rigid_motions_cost_no_energy(n: int) -> None:
    mesh = cylinder(0.0, 0.3)
    stiffness, _ = stiffness_and_mass(mesh, STEEL, n)
    y, r = mesh.points.T
    zero = 0 * r
    motions = {
        0: [(zero, zero + 1, zero)],
        1: [(zero + 1, zero, zero - 1), (y, -r, -y)],  # along theta = 0, and about the axis across it
        2: [],
    }
    for motion in motions[n]:
        u = np.stack(motion, axis=1).ravel()
        assert np.abs(stiffness @ u).max() < 1e-9 * stiffness.diagonal().max()
    dense = (free_unknowns(mesh, n).T @ stiffness @ free_unknowns(mesh, n)).toarray()
    values = np.linalg.eigvalsh(dense)
    assert (values < 1e-9 * values[-1]).sum() == len(motions[n])
