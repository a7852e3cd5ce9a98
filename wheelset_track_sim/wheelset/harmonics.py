"""Finite-element model of a wheelset for one harmonic: matrices, loads, supports, modes and statics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from ..runtime.arrays import Real
from .harmonic_elements import free_unknowns, shape_functions, solid_mass, stiffness_and_mass
from .section_mesh import RESOLUTION, SectionMesh
from .wheelset import Wheelset

HARMONICS = range(7)
"""n = 0 to 6: of the X40, n = 7 starts at 4.1 kHz, and 7 to 9 change receptances to 2500 Hz by less than 1e-12 m/N."""

GRAVITY = 9.81
"""m/s^2; 20 t are 196.2 kN."""

Direction = Literal["up", "left", "forward"]
DIRECTIONS: dict[Direction, tuple[int, float]] = {"up": (0, -1.0), "left": (1, 1.0), "forward": (2, -1.0)}
"""Unknown of a node that a displacement at the contact is, and its sign."""


@dataclass(frozen=True, eq=False)
class HarmonicModel:
    """Equations of motion of harmonic ``n`` in its free unknowns, without damping."""

    n: int
    stiffness: sp.csc_array
    mass: sp.csc_array
    free: sp.csc_array
    """(all unknowns, free unknowns)."""
    contacts: Real
    """(free unknowns, 2): a unit vertical force on wheel 1, 2; also what reads ``xi_w`` from the unknowns."""
    boxes: Real
    """(free unknowns, 2): the same for the axle boxes; zero unless n = 1."""
    bearings: Real
    """(free unknowns, 2): lift of the journals over their boxes; zero if the bearings are rigid."""

    def modes(self, max_frequency: float) -> tuple[Real, Real]:
        """Natural frequencies (modes,) in Hz to ``max_frequency`` and mass-normalised modes (free unknowns, modes).

        The axial rigid motion (n = 0), which no radial force excites, is left out.
        """
        shift = -((2 * np.pi * 100.0) ** 2)  # below every mode, so that the shifted matrix is positive definite
        solver = _factors(self.stiffness - shift * self.mass)
        size = self.mass.shape[0]
        inverse = LinearOperator((size, size), matvec=solver.solve, dtype=np.float64)
        start = np.random.default_rng(0).standard_normal(size)  # a fixed start: the same model gives the same modes
        count = 24
        while True:
            values, shapes = eigsh(self.stiffness, count, self.mass, sigma=shift, OPinv=inverse, v0=start)
            frequencies = np.sqrt(np.clip(values, 0.0, None)) / (2 * np.pi)
            if frequencies.max() > max_frequency:
                break
            count *= 2
        order = np.argsort(frequencies)
        kept = order[(frequencies[order] <= max_frequency) & ((frequencies[order] > 1.0) | (self.n > 0))]
        return frequencies[kept], shapes[:, kept]

    def static(self, forces: Real) -> Real:
        """Static displacements (free unknowns, cases) under forces (free unknowns, cases)."""
        stiffness = self.stiffness if self.n else held(self.stiffness, self.free)
        displacements: Real = _factors(stiffness).solve(forces)
        return displacements

    def weight(self) -> Real:
        """Weight of all masses (free unknowns,), N, as a body force: it is of n = 1, the only harmonic that moves.

        Gravity is -z at every angle: ``f = -g M e`` with the rigid lift ``e``, ``u_r = -cos(theta)`` and ``u_theta =
        sin(theta)``. Axle boxes and point masses count with their own masses; boxes on bearings are unknowns.
        """
        lift = np.tile([-1.0, 0.0, 1.0], self.free.shape[0] // 3)
        free, scale = self.free, self.free.multiply(self.free).sum(axis=0)
        rigid = np.divide(free.T @ lift, scale, out=np.ones(len(scale)), where=scale > 0.0)
        weight: Real = -GRAVITY * (self.mass @ rigid)
        return weight


def total_mass(wheelset: Wheelset, mesh: SectionMesh) -> float:
    """Mass of a wheelset with axle boxes and equipment, kg."""
    solid = solid_mass(mesh, wheelset.material)
    return solid + 2 * wheelset.axle_boxes.mass + sum(item.mass for item in wheelset.masses)


def held(stiffness: sp.csc_array, free: sp.csc_array) -> sp.csc_array:
    """Stiffness of n = 0, which is free to move along y or to turn, with one such unknown held.

    Forces in equilibrium leave no force there, and the same stress.
    """
    place = int(np.flatnonzero(free.indices % 3 != 0)[0])
    hold = sp.coo_array(([stiffness.diagonal().max()], ([place], [place])), shape=stiffness.shape)
    return sp.csc_array(stiffness + hold)


def harmonic(wheelset: Wheelset, mesh: SectionMesh, n: int) -> HarmonicModel:
    """Model of harmonic ``n``; axle boxes, suspension and point masses act on n = 1, which alone moves the sections.

    Axle boxes on elastic bearings have two unknowns of their own, their lift, after those of the mesh::

        m y'' + k_b (y - e) + k y = 0                        e  mean lift of the journal's bearing surface
        M u'' + K u + sum b k_b (e - y) = s F,  e = b . u    k  primary suspension, k_b  bearing
    """
    free = free_unknowns(mesh, n)
    stiffness, mass = (free.T @ matrix @ free for matrix in stiffness_and_mass(mesh, wheelset.material, n))
    boxes = np.zeros((free.shape[1], 2))
    bearings = boxes
    if n == 1:
        boxes = free.T @ bearing_displacements(wheelset, mesh)
        if wheelset.axle_boxes.bearing_stiffness is not None:
            bearings = np.vstack([boxes, -np.eye(2)])
            boxes = np.vstack([np.zeros_like(boxes), np.eye(2)])
            free, stiffness, mass = (
                sp.block_array([[matrix, None], [None, sp.csc_array((below, 2))]]).tocsc()
                for matrix, below in ((free, 0), (stiffness, 2), (mass, 2))
            )
            spread = sp.csc_array(bearings)
            stiffness = stiffness + wheelset.axle_boxes.bearing_stiffness * (spread @ spread.T)
        spread = sp.csc_array(boxes)
        stiffness = stiffness + wheelset.axle_boxes.stiffness * (spread @ spread.T)
        mass = mass + wheelset.axle_boxes.mass * (spread @ spread.T)
        for item in wheelset.masses:
            radius = wheelset.axle.section_over(*item.ends, item.name).diameter / 2
            motion = sp.csc_array(free.T @ section_motion(mesh, radius, *item.ends))
            mass = mass + motion @ sp.diags_array([item.mass, item.inertia]) @ motion.T
    contacts = free.T @ contact_displacements(wheelset, mesh, "up")
    return HarmonicModel(n, stiffness.tocsc(), mass.tocsc(), free, contacts, boxes, bearings)


def contact_displacements(wheelset: Wheelset, mesh: SectionMesh, direction: Direction) -> Real:
    """Vectors (all unknowns, 2) that read a displacement of wheels 1 and 2 at theta = 0, the lowest point of the tread.

    ``up`` is ``xi_w``, inwards, -u_r, and ``left`` is u_y, for every n; a force of 1 N enters every harmonic with
    weight 1. ``forward`` reads u_theta of the fields that are antisymmetric about theta = 0 (n > 0)::

        u_r = U_r sin(n theta),  u_y = U_y sin(n theta),  u_theta = -U_theta cos(n theta)

    They are the symmetric ones turned by a quarter of a period, with the same matrices.
    """
    vectors = np.zeros((3 * len(mesh.points), 2))
    unknown, sign = DIRECTIONS[direction]
    for wheel, y in enumerate(wheelset.contact_positions):
        nodes, weights = on_surface(mesh, wheelset.wheel.rolling_radius, y, y)
        np.add.at(vectors[:, wheel], 3 * nodes + unknown, sign * weights)
    return vectors


def bearing_displacements(wheelset: Wheelset, mesh: SectionMesh) -> Real:
    """Vectors (all unknowns, 2) that read the mean upward displacement of the bearing surfaces (n = 1)."""
    return np.stack([section_motion(mesh, *surface)[:, 0] for surface in bearing_surfaces(wheelset)], axis=1)


def bearing_surfaces(wheelset: Wheelset) -> list[tuple[float, float, float]]:
    """Radius, first and last y, m, of the journals' surfaces under the axle boxes next to wheels 1 and 2."""
    boxes = wheelset.axle_boxes
    found = []
    for side in (-1, 1):
        low, high = (side * boxes.distance + end * boxes.bearing_length / 2 for end in (-1, 1))
        found.append((wheelset.axle.section_over(low, high, "bearing of the axle box").diameter / 2, low, high))
    return found


def section_motion(mesh: SectionMesh, radius: float, low: float, high: float) -> Real:
    """Vectors (all unknowns, 2) that read lift and tilt (n = 1) of a cylinder's surface from y = ``low`` to ``high``.

    Lift is the mean upward displacement: around the section, the mean of u_r cos(theta) - u_theta sin(theta) is
    (U_r - U_theta) / 2, downwards. Tilt is the mean rotation about x, the amplitude U_y over the radius.
    """
    vectors = np.zeros((3 * len(mesh.points), 2))
    nodes, weights = on_surface(mesh, radius, low, high)
    np.add.at(vectors[:, 0], 3 * nodes, -weights / 2)
    np.add.at(vectors[:, 0], 3 * nodes + 2, weights / 2)
    np.add.at(vectors[:, 1], 3 * nodes + 1, weights / radius)
    return vectors


def on_surface(mesh: SectionMesh, radius: float, low: float, high: float) -> tuple[NDArray[np.int64], Real]:
    """Nodes and weights of the mean over ``low`` to ``high`` in y (or the value at one y) on a cylinder."""
    line = np.flatnonzero(np.abs(mesh.points[:, 1] - radius) < RESOLUTION)
    inside: list[tuple[NDArray[np.int64], Real]] = []
    sides = mesh.elements[:, [[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]]].reshape(-1, 3)
    for side in sides[np.isin(sides, line).all(axis=1)]:
        start, end = mesh.points[side[0], 0], mesh.points[side[2], 0]
        first, last = min(start, end), max(start, end)
        if first - RESOLUTION <= low and high <= last + RESOLUTION and low == high:
            xi = 2 * (low - start) / (end - start) - 1
            values, _ = shape_functions(np.array([[xi, -1.0]]))
            return side, values[0, [0, 4, 1]]
        if low - RESOLUTION <= first and last <= high + RESOLUTION:
            inside.append((side, np.array([1.0, 4.0, 1.0]) / 6 * (last - first) / (high - low)))
    if not inside:
        raise ValueError(f"no element sides on radius {radius:g} m from y = {low:g} to {high:g} m")
    return np.concatenate([side for side, _ in inside]), np.concatenate([weights for _, weights in inside])


def _factors(matrix: sp.csc_array) -> SuperLU:
    """Factors of a symmetric positive definite matrix."""
    options = {"SymmetricMode": True}
    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
