"""Harmonic elements against the exact waves of an elastic cylinder (Pochhammer and Chree).

A cylinder of length L between planes that hold u_y has modes cos(n theta) with u_y ~ sin(k y), k = pi / L, exactly as
in an infinite one. Displacements come from three potentials with Bessel functions (e.g. K. F. Graff, "Wave Motion in
Elastic Solids", Section 8.2); the determinant of the tractions on the surface vanishes at a natural frequency.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import jvp

from wheelset_track_sim.wheelset.harmonic_elements import free_unknowns, stiffness_and_mass
from wheelset_track_sim.wheelset.parts import Material
from wheelset_track_sim.wheelset.section_mesh import divided, grid, joined

STEEL = Material(density=7810.0, youngs_modulus=210e9, poissons_ratio=0.3, mass_damping=0.0, stiffness_damping=0.0)
RADIUS, LENGTH = 0.09, 0.4


def surface_tractions(n: int, frequency: float) -> float:
    """Determinant of the tractions rr, r theta, ry that the three potentials make on the surface."""
    omega, k, r = 2 * np.pi * frequency, np.pi / LENGTH, RADIUS
    mu = STEEL.youngs_modulus / (2 * (1 + STEEL.poissons_ratio))
    lame = 2 * mu * STEEL.poissons_ratio / (1 - 2 * STEEL.poissons_ratio)
    p = np.sqrt(omega**2 * STEEL.density / (lame + 2 * mu) - k**2 + 0j)
    q = np.sqrt(omega**2 * STEEL.density / mu - k**2 + 0j)
    columns = []
    for kind, s in (("pressure", p), ("shear across", q), ("shear along", q)):
        j, j1, j2 = (s**order * jvp(n, s * r, order) for order in range(3))
        if kind == "shear across":
            u, du = n * j / r, n * (j1 / r - j / r**2)
            v, dv, w, dw = -j1, -j2, 0, 0
        else:
            u, du = j1, j2
            v, dv = -n * j / r, -n * (j1 / r - j / r**2)
            w, dw = (-k * j, -k * j1) if kind == "pressure" else (q**2 / k * j, q**2 / k * j1)
        column = np.array(
            [
                lame * (du + (u + n * v) / r + k * w) + 2 * mu * du,
                mu * (-n * u / r + dv - v / r),
                mu * (dw - k * u),
            ]
        )
        # An imaginary wavenumber leaves the factor i^n: the column is real without it.
        columns.append((column / (1j**n if s.imag else 1.0)).real)
    matrix = np.array(columns).T
    if n == 0:  # torsion stands apart
        matrix = matrix[np.ix_([0, 2], [0, 2])]
    return float(np.linalg.det(matrix / np.abs(matrix).max(axis=0)))


@pytest.mark.parametrize(("n", "modes"), [(0, 2), (1, 3), (2, 2), (3, 2)])
@pytest.mark.slow
def test_modes_of_a_cylinder(n: int, modes: int) -> None:
    mesh = joined([grid(divided([0.0, LENGTH], 0.03)[:, None], divided([0.0, RADIUS], 0.02)[None, :])])
    ends = (mesh.points[:, 0] == 0.0) | (np.abs(mesh.points[:, 0] - LENGTH) < 1e-9)
    free = free_unknowns(mesh, n)
    held = np.zeros(3 * len(mesh.points))
    held[1::3] = ends
    free = free[:, np.flatnonzero(free.T @ held == 0)]
    stiffness, mass = ((free.T @ matrix @ free).toarray() for matrix in stiffness_and_mass(mesh, STEEL, n))
    factor = np.linalg.inv(np.linalg.cholesky(mass))
    values, shapes = np.linalg.eigh(factor @ stiffness @ factor.T)
    shapes = (free @ (factor.T @ shapes)).reshape(len(mesh.points), 3, -1)
    # The mode with one half wave: what it keeps when weighted with sin(pi y / L) or cos(pi y / L).
    wave = np.cos(np.pi * mesh.points[:, 0] / LENGTH)
    line = np.abs(mesh.points[:, 1] - RADIUS) < 1e-9
    radial = shapes[line][:, 0] if n == 0 else shapes[line][:, 2]
    match = np.abs(wave[line] @ radial) / (np.linalg.norm(wave[line]) * np.linalg.norm(radial, axis=0) + 1e-30)
    found = np.sqrt(np.abs(values[match > 0.99])) / (2 * np.pi)
    assert len(found) >= modes
    for frequency in found[:modes]:
        low, high = surface_tractions(n, frequency * (1 - 1e-4)), surface_tractions(n, frequency * (1 + 1e-4))
        assert low * high < 0, f"n = {n}: no exact natural frequency within 1e-4 of {frequency:.1f} Hz"
