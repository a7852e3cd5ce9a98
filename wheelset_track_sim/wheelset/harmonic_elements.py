"""Solid of revolution in Fourier harmonics: 8-node quadrilaterals in (y, r), displacements cos(n theta).

Displacements symmetric about theta = 0::

    u_r = U_r(y, r) cos(n theta),  u_y = U_y(y, r) cos(n theta),  u_theta = U_theta(y, r) sin(n theta)

split three-dimensional elasticity into one two-dimensional problem for each n (O. C. Zienkiewicz, R. L. Taylor, "The
Finite Element Method for Solid and Structural Mechanics", semi-analytical finite elements). Unknowns of node k are
U_r, U_y, U_theta at 3 k, 3 k + 1, 3 k + 2. Strains and stresses are ordered rr, yy, theta theta, ry, r theta, y theta;
the last two go with sin(n theta), shear strains are engineering ones.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..runtime.arrays import Real
from .parts import Material
from .section_mesh import SectionMesh

SIGNS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
GAUSS_3 = np.polynomial.legendre.leggauss(3)
NODES = np.array([*SIGNS, (0, -1), (1, 0), (0, 1), (-1, 0)])
"""Local coordinates of the nodes."""


def shape_functions(points: Real) -> tuple[Real, Real]:
    """Values (..., 8) and derivatives (..., 8, 2) of the serendipity functions at local points (..., 2)."""
    xi, eta = points[..., :1], points[..., 1:]
    a, b = SIGNS[:, 0], SIGNS[:, 1]
    along, across = 1 - xi**2, 1 - eta**2
    side, end = np.array([-1, 1]), np.array([1, -1])
    values = np.empty((*points.shape[:-1], 8))
    values[..., :4] = (1 + a * xi) * (1 + b * eta) * (a * xi + b * eta - 1) / 4
    values[..., 4::2] = along * (1 + side * eta) / 2
    values[..., 5::2] = across * (1 + end * xi) / 2
    slopes = np.empty((*values.shape, 2))
    slopes[..., :4, 0] = a * (1 + b * eta) * (2 * a * xi + b * eta) / 4
    slopes[..., :4, 1] = b * (1 + a * xi) * (a * xi + 2 * b * eta) / 4
    slopes[..., 4::2, 0], slopes[..., 4::2, 1] = -xi * (1 + side * eta), side * along / 2
    slopes[..., 5::2, 0], slopes[..., 5::2, 1] = end * across / 2, -eta * (1 + end * xi)
    return values, slopes


def elasticity(material: Material) -> Real:
    """Matrix (6, 6) from strains to stresses, Pa."""
    nu = material.poissons_ratio
    shear = material.youngs_modulus / (2 * (1 + nu))
    matrix = np.diag(np.repeat([2 * shear, shear], 3))
    matrix[:3, :3] += 2 * shear * nu / (1 - 2 * nu)
    return matrix


def stiffness_and_mass(mesh: SectionMesh, material: Material, n: int) -> tuple[sp.csc_array, sp.csc_array]:
    """Stiffness and mass matrices of harmonic ``n`` over all unknowns, integrated over the circumference."""
    points, weights = _gauss_points()
    values, _ = shape_functions(points)
    strain, area, radius = _strain(mesh, points, n)
    # Integral of cos^2 (n theta) around: pi, and 2 pi for n = 0.
    measure = area * weights * radius * (np.pi if n else 2 * np.pi)
    stiffness = np.einsum("egsi,eg,st,egtj->eij", strain, measure, elasticity(material), strain, optimize=True)
    mass = np.zeros_like(stiffness)
    block = material.density * np.einsum("ga,eg,gb->eab", values, measure, values, optimize=True)
    for component in range(3):
        mass[:, component::3, component::3] = block
    unknowns = _unknowns(mesh)
    rows, columns = np.repeat(unknowns, 24, axis=1).ravel(), np.tile(unknowns, 24).ravel()
    size = 3 * len(mesh.points)
    return (
        sp.coo_array((stiffness.ravel(), (rows, columns)), shape=(size, size)).tocsc(),
        sp.coo_array((mass.ravel(), (rows, columns)), shape=(size, size)).tocsc(),
    )


def solid_mass(mesh: SectionMesh, material: Material) -> float:
    """Mass of the whole body of revolution, kg."""
    points, weights = _gauss_points()
    _, area, radius = _strain(mesh, points, 0)
    return float(2 * np.pi * material.density * (area * weights * radius).sum())


def free_unknowns(mesh: SectionMesh, n: int) -> sp.csc_array:
    """Matrix from free unknowns to all: single-valued displacements on the axis, and no torsion for n = 0."""
    count = len(mesh.points)
    target = np.arange(3 * count)
    keep = np.ones(3 * count, dtype=bool)
    axis = np.flatnonzero(mesh.points[:, 1] == 0.0)
    if n == 0:
        keep[2::3] = False
        keep[3 * axis] = False
    else:
        keep[3 * axis + 1] = False
        keep[3 * axis + 2] = False
        if n > 1:
            keep[3 * axis] = False
    column = np.cumsum(keep) - 1
    rows, columns, entries = target[keep], column[keep], np.ones(keep.sum())
    if n == 1:  # A point of the axis moves in the plane theta = 0 as a whole: U_theta = -U_r.
        rows = np.concatenate([rows, 3 * axis + 2])
        columns = np.concatenate([columns, column[3 * axis]])
        entries = np.concatenate([entries, -np.ones(len(axis))])
    return sp.coo_array((entries, (rows, columns)), shape=(3 * count, keep.sum())).tocsc()


def nodal_stress(mesh: SectionMesh, material: Material, n: int, nodes: NDArray[np.int64]) -> sp.csr_array:
    """Matrix (6 * nodes, unknowns) of stress amplitudes of harmonic ``n`` at nodes, Pa per m.

    Each element's own value at the node, averaged over its elements: along a free surface smoother and, when the mesh
    is refined, steadier than what is extrapolated from inside (Barlow) points.
    """
    rows, columns, entries = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for place, node in enumerate(nodes):
        elements, local = np.nonzero(mesh.elements == node)
        part = SectionMesh(mesh.points, mesh.elements[elements])
        strain, _, _ = _strain(part, NODES[local][:, None], n)
        stress = np.einsum("st,eti->esi", elasticity(material), strain[:, 0]) / len(elements)
        unknowns = _unknowns(part)
        for component in range(6):
            rows.append(np.full(unknowns.size, 6 * place + component))
            columns.append(unknowns.ravel())
            entries.append(stress[:, component].ravel())
    where = (np.concatenate(rows), np.concatenate(columns))
    return sp.coo_array((np.concatenate(entries), where), shape=(6 * len(nodes), 3 * len(mesh.points))).tocsr()


def _gauss_points() -> tuple[Real, Real]:
    """Points (9, 2) and weights (9,) of the 3 x 3 rule."""
    x, w = GAUSS_3
    return np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(w, w).ravel()


def _unknowns(mesh: SectionMesh) -> NDArray[np.int64]:
    """Unknowns (elements, 24) of the elements, node by node."""
    return (3 * mesh.elements[:, :, None] + np.arange(3)).reshape(len(mesh.elements), 24)


def _strain(mesh: SectionMesh, points: Real, n: int) -> tuple[Real, Real, Real]:
    """Strain matrices (elements, points, 6, 24), areas |J| and radii (elements, points).

    ``points`` are local: (points, 2) the same in all elements, or (elements, points, 2).
    """
    values, slopes = (
        np.broadcast_to(part, (len(mesh.elements), *part.shape[points.ndim - 2 :])) for part in shape_functions(points)
    )
    places = mesh.points[mesh.elements]
    jacobian = np.einsum("egak,eal->egkl", slopes, places)
    area = np.linalg.det(jacobian)
    if (area <= 0).any():
        raise ValueError(f"element {int(np.nonzero(area <= 0)[0][0])} is inside out or degenerate")
    gradient = np.einsum("eglk,egak->egal", np.linalg.inv(jacobian), slopes)
    radius = np.einsum("ega,ea->eg", values, places[:, :, 1])
    y, r = gradient[..., 0], gradient[..., 1]
    over_r = values / radius[..., None]
    strain = np.zeros((*area.shape, 6, 24))
    strain[:, :, 0, 0::3] = r
    strain[:, :, 1, 1::3] = y
    strain[:, :, 2, 0::3] = over_r
    strain[:, :, 2, 2::3] = n * over_r
    strain[:, :, 3, 0::3] = y
    strain[:, :, 3, 1::3] = r
    strain[:, :, 4, 0::3] = -n * over_r
    strain[:, :, 4, 2::3] = r - over_r
    strain[:, :, 5, 1::3] = -n * over_r
    strain[:, :, 5, 2::3] = y
    return strain, area, radius
