"""From nodes of the section mesh to stresses at stress nodes: which mesh nodes, at which angle, with which weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import NamedTuple, TypeVar

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..samples import principal
from . import mesh as wheelset_mesh
from .harmonic_elements import nodal_stress, shape_functions
from .reduced import COMPONENTS
from .section_mesh import RESOLUTION, SectionMesh
from .stress_node import StressNode
from .wheelset import Wheelset

Scalar = TypeVar("Scalar", np.float64, np.complex128)


class Pick(NamedTuple):
    """Samples whose weighted sum is the stress at a node."""

    rows: NDArray[np.int64]
    weights: Real


class _Wanted(NamedTuple):
    """Samples of one stress node: rows with given weights, or rows of which one is chosen."""

    rows: NDArray[np.int64]
    weights: Real | None
    """None if the row counts in whose place the top of the fillet is stressed most."""
    tops: NDArray[np.int64]
    """Rows in the same places on the top."""


@dataclass(frozen=True, eq=False)
class StressPoints:
    """Samples of stress on the axle's surface: C mesh nodes, each seen at an angle from the top."""

    nodes: NDArray[np.int64]
    """(C,) of the mesh."""
    angles: Real
    """(C,) rad."""
    wanted: tuple[_Wanted, ...]

    def turned(self, n: int) -> sp.coo_array:
        """Matrix (6 C, 6 C) from stress amplitudes of harmonic ``n`` to components in x, y, z."""
        if not len(self.nodes):
            return sp.coo_array((0, 0))
        return sp.coo_array(sp.block_diag([around_axle(n, angle) for angle in self.angles]))

    def picks(self, static: Real) -> list[Pick]:
        """Weights of each stress node; ``static`` (C, 6) shows the most stressed place of a fillet."""
        highest = principal.maximum_principal(static)
        found = []
        for rows, weights, tops in self.wanted:
            if weights is None:
                found.append(Pick(rows[[highest[tops].argmax()]], np.ones(1)))
            else:
                found.append(Pick(rows, weights))
        return found


def stress_points(wheelset: Wheelset, mesh: SectionMesh) -> StressPoints:
    """Samples for all stress nodes of a wheelset."""
    nodes: list[NDArray[np.int64]] = [np.zeros(0, dtype=np.int64)]
    angles: list[Real] = [np.zeros(0)]
    wanted = []

    def rows(arc: NDArray[np.int64], angle: float) -> NDArray[np.int64]:
        first = sum(len(part) for part in nodes)
        nodes.append(arc)
        angles.append(np.full(len(arc), angle))
        return first + np.arange(len(arc))

    for node in wheelset.stress_nodes:
        if node.y is None:
            arc = mesh.nodes_on(wheelset_mesh.stress_fillet(wheelset, node))
            tops = rows(arc, 0.0)
            wanted.append(_Wanted(tops if node.angle == 0 else rows(arc, node.angle), None, tops))
        else:
            arc, weights = on_axle(wheelset, mesh, node.y)
            here = rows(arc, node.angle)
            wanted.append(_Wanted(here, weights, here))
    return StressPoints(np.concatenate(nodes), np.concatenate(angles), tuple(wanted))


def combined(values: NDArray[Scalar], picks: Sequence[Pick]) -> NDArray[Scalar]:
    """Values (C, ...) of samples as those of the stress nodes (N, ...); a single sample comes out as it is."""
    found = np.zeros((len(picks), *values.shape[1:]), dtype=values.dtype)
    for node, (rows, weights) in enumerate(picks):
        found[node] = values[rows[0]] if len(rows) == 1 else np.tensordot(weights, values[rows], axes=1)
    return found


def positions(wheelset: Wheelset, nodes: Sequence[StressNode], y: Real) -> Real:
    """Places (N, 3) of stress nodes with axial positions ``y``: x, y, z, m."""
    r, angle = wheelset_mesh.surface_radius(wheelset, y), np.array([node.angle for node in nodes])
    return np.stack([r * np.sin(angle), y, r * np.cos(angle)], axis=1)


def on_axle(wheelset: Wheelset, mesh: SectionMesh, y: float) -> tuple[NDArray[np.int64], Real]:
    """The three mesh nodes of the side of the axle's surface that holds ``y``, and what each counts there."""
    along, r = mesh.points.T
    surface = np.abs(r - wheelset_mesh.surface_radius(wheelset, along)) < RESOLUTION
    sides = mesh.elements[:, [[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]]].reshape(-1, 3)
    sides = sides[surface[sides].all(axis=1)]
    low, high = np.sort(along[sides][:, [0, 2]], axis=1).T
    side = sides[np.flatnonzero((low - RESOLUTION <= y) & (y <= high + RESOLUTION))[0]]
    start, middle, end = along[side]
    # y = middle + (end - start) / 2 xi + ((start + end) / 2 - middle) xi^2; in a fillet the middle is not halfway.
    roots = np.roots([(start + end) / 2 - middle, (end - start) / 2, middle - y]).real
    xi = roots[np.abs(roots).argmin()]
    values, _ = shape_functions(np.array([[xi, -1.0]]))
    return side, values[0, [0, 4, 1]]


def surface_amplitudes(wheelset: Wheelset, mesh: SectionMesh, n: int, displacements: Real, y: Real) -> Real:
    """Stress amplitudes (N, 6) of harmonic ``n`` on the axle's surface at ``y`` (N,), by all displacements, m."""
    found = np.zeros((len(y), 6))
    for place, along in enumerate(y):
        nodes, weights = on_axle(wheelset, mesh, float(along))
        amplitudes = (nodal_stress(mesh, wheelset.material, n, nodes) @ displacements).reshape(-1, 6)
        found[place] = weights @ amplitudes
    return found


def around_axle(n: int, angle: float) -> Real:
    """Matrix (6, 6) from stress amplitudes of harmonic ``n`` to components in x, y, z at ``angle`` rad from the top.

    There theta is pi - angle.
    """
    sign = (-1.0) ** n
    return in_axes(angle, sign * cos(n * angle), -sign * sin(n * angle))


def in_axes(angle: float, even: float, odd: float) -> Real:
    """Matrix (6, 6) from polar components, the first four times ``even``, the others ``odd``, to those in x, y, z.

    At ``angle`` rad from the top r points to (sin, 0, cos) of the angle, theta to (-cos, 0, sin).
    """
    c, s = cos(angle), sin(angle)
    r, y, t = np.array([s, 0.0, c]), np.array([0.0, 1.0, 0.0]), np.array([-c, 0.0, s])
    amplitudes = ((r, r, even), (y, y, even), (t, t, even), (r, y, even), (r, t, odd), (y, t, odd))
    matrix = np.zeros((6, 6))
    for column, (a, b, amplitude) in enumerate(amplitudes):
        tensor = amplitude * (np.outer(a, b) if a is b else np.outer(a, b) + np.outer(b, a))
        for row, name in enumerate(COMPONENTS):
            matrix[row, column] = tensor["xyz".index(name[0]), "xyz".index(name[1])]
    return matrix
