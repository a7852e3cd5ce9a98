"""A second, independent model of a wheelset: 20-node bricks in three dimensions, half of it, Cartesian unknowns.

It shares the geometry and the section mesh with the harmonic elements, nothing else: the section is revolved over
theta = 0 to pi, elements have their own shape functions, integration, assembly, loads and stress recovery.
Coordinates are (y, 1, 2): along the axle, towards theta = 0 (down), and across; the plane 1-y is one of symmetry.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from wheelset_track_sim.wheelset.harmonics import HarmonicModel
from wheelset_track_sim.wheelset.section_mesh import SectionMesh
from wheelset_track_sim.wheelset.wheelset import Wheelset

Real = NDArray[np.float64]
Index = NDArray[np.int64]

# The order of the section's nodes at the first and the second end of a brick, then its corners halfway.
FLAT = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)]
LOCAL = np.array(
    [(*place, -1) for place in FLAT] + [(*place, 1) for place in FLAT] + [(*place, 0) for place in FLAT[:4]]
)


def shape(points: Real) -> tuple[Real, Real]:
    """Values (points, 20) and derivatives (points, 20, 3); the latter by complex steps, exact for polynomials."""

    def values(at: NDArray[np.complex128]) -> NDArray[np.complex128]:
        factors = 1 + LOCAL[None] * at[:, None, :]
        corner = factors.prod(axis=2) * ((LOCAL[None] * at[:, None, :]).sum(axis=2) - 2) / 8
        middle = np.where(LOCAL[None] == 0, 1 - at[:, None, :] ** 2, factors).prod(axis=2) / 4
        return np.where((LOCAL != 0).all(axis=1), corner, middle)

    step = 1e-30
    slopes = [values(points + 1j * step * np.eye(3)[axis]).imag / step for axis in range(3)]
    return values(points.astype(complex)).real, np.stack(slopes, axis=-1)


@dataclass(frozen=True, eq=False)
class Bricks:
    """Half model: matrices over the free unknowns, and what connects them to the section mesh."""

    points: Real
    """(nodes, 3)."""
    elements: Index
    """(elements, 20)."""
    numbers: Index
    """(section nodes, angles): node of the solid, -1 where there is none."""
    angles: Real
    free: Index
    """Unknowns that are free: three a node, y, 1, 2."""
    stiffness: sp.csc_array
    mass: sp.csc_array
    elasticity: Real

    def factors(self, shift: float) -> SuperLU:
        """Factors of K + shift M."""
        return splu(
            (self.stiffness + shift * self.mass).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def modes(self, count: int) -> tuple[Real, Real]:
        """Lowest natural frequencies (count,), Hz, and modes (free unknowns, count)."""
        shift = (2 * np.pi * 100.0) ** 2
        inverse = LinearOperator(self.mass.shape, matvec=self.factors(shift).solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(len(self.free))
        values, shapes = eigsh(self.stiffness, count, self.mass, sigma=-shift, OPinv=inverse, v0=start, tol=1e-9)
        return np.sqrt(np.abs(values)) / (2 * np.pi), shapes

    def full(self, unknowns: Real) -> Real:
        """Displacements (nodes, 3) from the free unknowns."""
        displacements = np.zeros(3 * len(self.points))
        displacements[self.free] = unknowns
        return displacements.reshape(-1, 3)

    def stress(self, node: int, displacements: Real) -> Real:
        """Stress (yy, 11, 22, y1, 12, y2) at a node, the mean over its elements, Pa."""
        elements, local = np.nonzero(self.elements == node)
        found = []
        for element, place in zip(self.elements[elements], local, strict=True):
            strain, _, _ = strains(self.points[element][None], LOCAL[place][None].astype(float))
            found.append(self.elasticity @ strain[0, 0] @ displacements[element].ravel())
        return np.mean(found, axis=0)


def strains(places: Real, points: Real) -> tuple[Real, Real, Real]:
    """Strain matrices (elements, points, 6, 60), volumes |J| (elements, points) and shape values (points, 20)."""
    values, slopes = shape(points)
    jacobian = np.einsum("gak,eal->egkl", slopes, places)
    gradient = np.einsum("eglk,gak->egal", np.linalg.inv(jacobian), slopes)
    y, a, b = np.moveaxis(gradient, -1, 0)
    strain = np.zeros((*jacobian.shape[:2], 6, 60))
    strain[:, :, 0, 0::3], strain[:, :, 1, 1::3], strain[:, :, 2, 2::3] = y, a, b
    strain[:, :, 3, 0::3], strain[:, :, 3, 1::3] = a, y
    strain[:, :, 4, 1::3], strain[:, :, 4, 2::3] = b, a
    strain[:, :, 5, 0::3], strain[:, :, 5, 2::3] = b, y
    return strain, np.linalg.det(jacobian), values


def bricks(wheelset: Wheelset, mesh: SectionMesh, sectors: int) -> Bricks:
    """Half model of a wheelset with ``sectors`` bricks around the half circumference."""
    angles = np.linspace(0.0, np.pi, 2 * sectors + 1)
    numbers, elements = _revolved(mesh, sectors)
    points = np.zeros((numbers.max() + 1, 3))
    for index, angle in enumerate(angles):
        there = numbers[:, index] >= 0
        y, r = mesh.points[there].T
        points[numbers[there, index]] = np.stack([y, r * np.cos(angle), r * np.sin(angle)], axis=1)

    young, nu = wheelset.material.youngs_modulus, wheelset.material.poissons_ratio
    elasticity = young / (1 + nu) * np.diag([1, 1, 1, 0.5, 0.5, 0.5])
    elasticity[:3, :3] += young * nu / ((1 + nu) * (1 - 2 * nu))
    stiffness, mass = _assembled(points, elements, elasticity, wheelset.material.density)
    for side in (-1, 1):
        mean = sp.csc_array(_bearing(wheelset, mesh, numbers, side)[:, None])
        # Half an axle box and half a suspension on half a wheelset.
        stiffness = stiffness + wheelset.axle_boxes.stiffness / 2 * (mean @ mean.T)
        mass = mass + wheelset.axle_boxes.mass / 2 * (mean @ mean.T)
    held = np.zeros((len(points), 3), dtype=bool)
    held[:, 2] = np.abs(points[:, 2]) < 1e-9
    free = np.flatnonzero(~held.ravel())
    return Bricks(
        points,
        elements,
        numbers,
        angles,
        free,
        stiffness.tocsc()[free][:, free].tocsc(),
        mass.tocsc()[free][:, free].tocsc(),
        elasticity,
    )


def on_bricks(solid: Bricks, model: HarmonicModel, unknowns: Real) -> Real:
    """Displacements of a harmonic at the free unknowns of the bricks."""
    u_r, u_y, u_t = (model.free @ unknowns).reshape(-1, 3).T
    field = np.zeros((len(solid.points), 3))
    for index, angle in enumerate(solid.angles):
        there = solid.numbers[:, index] >= 0
        radial, around = u_r[there] * np.cos(model.n * angle), u_t[there] * np.sin(model.n * angle)
        along = u_y[there] * np.cos(model.n * angle)
        down = radial * np.cos(angle) - around * np.sin(angle)
        across = radial * np.sin(angle) + around * np.cos(angle)
        field[solid.numbers[there, index]] = np.stack([along, down, across], axis=1)
    return field.ravel()[solid.free]


def _revolved(mesh: SectionMesh, sectors: int) -> tuple[Index, Index]:
    """Numbers (section nodes, angles) and bricks; nodes on the axis are one for all angles."""
    numbers = np.full((len(mesh.points), 2 * sectors + 1), -1)
    corner = np.isin(np.arange(len(mesh.points)), mesh.elements[:, :4])
    axis = mesh.points[:, 1] == 0
    numbers[axis] = np.arange(axis.sum())[:, None]
    used = np.ones_like(numbers, dtype=bool)
    used[axis] = False
    used[~corner, 1::2] = False
    numbers[used] = axis.sum() + np.arange(used.sum())
    elements = [
        np.concatenate(
            [
                numbers[mesh.elements, 2 * sector],
                numbers[mesh.elements, 2 * sector + 2],
                numbers[mesh.elements[:, :4], 2 * sector + 1],
            ],
            axis=1,
        )
        for sector in range(sectors)
    ]
    return numbers, np.concatenate(elements)


def _assembled(points: Real, elements: Index, elasticity: Real, density: float) -> tuple[sp.csc_array, sp.csc_array]:
    line, weight = np.polynomial.legendre.leggauss(3)
    gauss = np.array(list(product(line, repeat=3)))
    weights = np.array([np.prod(w) for w in product(weight, repeat=3)])
    size = 3 * len(points)
    stiffness, mass = sp.csc_array((size, size)), sp.csc_array((size, size))
    for part in np.array_split(elements, max(1, len(elements) // 400)):
        strain, volume, values = strains(points[part], gauss)
        measure = volume * weights
        assert (volume > 0).all()
        turned = np.einsum("st,egti->egsi", elasticity, strain) * measure[:, :, None, None]
        k = strain.reshape(len(part), -1, 60).transpose(0, 2, 1) @ turned.reshape(len(part), -1, 60)
        scalar = np.einsum("ga,eg,gb->eab", values, density * measure, values, optimize=True)
        m = np.einsum("eab,ij->eaibj", scalar, np.eye(3)).reshape(len(part), 60, 60)
        unknowns = (3 * part[:, :, None] + np.arange(3)).reshape(len(part), 60)
        where = np.repeat(unknowns, 60, axis=1).ravel(), np.tile(unknowns, 60).ravel()
        stiffness = stiffness + sp.coo_array((k.ravel(), where), shape=(size, size)).tocsc()
        mass = mass + sp.coo_array((m.ravel(), where), shape=(size, size)).tocsc()
    return stiffness, mass


def _bearing(wheelset: Wheelset, mesh: SectionMesh, numbers: Index, side: int) -> Real:
    """Weights of the mean downward displacement over a bearing surface: faces of 8 nodes, equal in area a strip."""
    boxes = wheelset.axle_boxes
    radius = wheelset.axle.sections[0 if side < 0 else -1].diameter / 2
    y, r = mesh.points.T
    inside = np.abs(side * y - boxes.distance) < boxes.bearing_length / 2 + 1e-9
    on = inside & (np.abs(r - radius) < 1e-9)
    sides = mesh.elements[:, [[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]]].reshape(-1, 3)
    strips = sides[on[sides].all(axis=1)]
    sectors = numbers.shape[1] // 2
    weights = np.zeros((numbers.max() + 1, 3))
    for start, middle, end in strips:
        share = abs(y[end] - y[start]) / boxes.bearing_length / sectors
        for first in range(0, 2 * sectors, 2):
            corners = numbers[[start, end]][:, [first, first + 2]].ravel()
            middles = [numbers[middle, first], numbers[middle, first + 2], *numbers[[start, end], first + 1]]
            weights[corners, 1] -= share / 12
            weights[middles, 1] += share / 3
    assert abs(weights.sum() - 1) < 1e-9
    return weights.ravel()
