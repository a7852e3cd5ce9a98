"""Rows that read the signals of sensors from a wheelset's modes: motion, suspension force and strain.

The modes eta (Q,) of a wheelset, undamped and of unit modal mass, move under contact forces F (2,)::

    eta'' + D eta' + Omega^2 eta = s F

A row is a signal that is linear in them and their rates. With the state q of ``reduced``, eta = Re(R q) and
q' = lambda q + b F, so that each row becomes an output of the same state as everything else, and no signal is
differentiated in time::

    y = w_0 . eta + w_1 . eta' + w_2 . eta'' + d F
      = Re(sum_o (w_o R) lambda^o q) + [Re((w_2 R) lambda b) + d] F

Re(R b) F, what a force adds to a velocity at once, is zero: forces accelerate masses.

    motion      w_o is the vertical shape of a place, o = 0, 1, 2 for displacement, velocity, acceleration
    suspension  w_0 = k (box - frame), w_1 = c (box - frame), of the lift of axle box and bogie frame
    strain      w_0 is the strain of each mode; d is the static strain less that of the modes, as for stress

A shape has no such residual: a force would displace a place by it at once, which no acceleration can follow.

Strain. On the surface of the axle, at an angle alpha from the top, the axial strain of harmonic n is (-1)^n E_n(t)
cos(n alpha). A gauge that turns sees all of them at its own angle (``sensors.kinds``); one that is fixed in space is
one row, their sum at a constant angle.

Source: state-space form of the modal sum; Hooke's law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import TypeAlias

import numpy as np

from ..runtime.arrays import Complex, Real
from .harmonic_elements import nodal_stress
from .harmonics import HARMONICS
from .section_mesh import SectionMesh
from .stress_points import on_axle
from .wheelset import Wheelset

FAR = 0.025
"""Largest distance of a place from the node of the mesh that stands for it, m: the size of an element."""


@dataclass(frozen=True)
class BoxMotion:
    """Vertical motion of the axle box next to a wheel, upwards."""

    wheel: int
    """0 or 1."""
    order: int
    """0 displacement, 1 velocity, 2 acceleration."""


@dataclass(frozen=True)
class PointMotion:
    """Vertical motion of a node of the finite-element model, fixed in space."""

    y: float
    r: float
    angle: float
    order: int


@dataclass(frozen=True)
class NamedMotion:
    """Vertical motion of a point of an imported wheelset."""

    name: str
    order: int


@dataclass(frozen=True)
class SuspensionReaction:
    """Force of the primary suspension at the axle box next to a wheel, positive in compression."""

    wheel: int


@dataclass(frozen=True)
class AxialStrain:
    """Axial strain on the axle's surface: amplitude of harmonic ``n``, or at an ``angle`` from the top if n is None."""

    y: float
    n: int | None
    angle: float = 0.0


SensorRow: TypeAlias = BoxMotion | PointMotion | NamedMotion | SuspensionReaction | AxialStrain


def rates(weights: Real, right: Complex, poles: Complex, inputs: Complex) -> tuple[Complex, Real]:
    """Outputs (S, P) and feedthrough (S, 2) of rows with ``weights`` (S, 3, Q) on modes, their first and second rates.

    ``right`` (Q, P), ``poles`` (P,) and ``inputs`` (P, 2) are those of the modes as in ``reduction.diagonalised``.
    """
    displacement, velocity, acceleration = (weights[:, order] @ right for order in range(3))
    feedthrough = (acceleration * poles @ inputs).real
    return displacement + velocity * poles + acceleration * poles**2, feedthrough


def box_weights(rows: Sequence[SensorRow], boxes: Real, frame: Real | None, spring: float, dashpot: float) -> Real:
    """Weights (S, 3, Q) of the rows of axle boxes and suspensions; zero for other rows.

    Parameters
    ----------
    rows
        S rows.
    boxes, frame
        Lift of Q modes at the axle boxes and at the frame's sides above them, (Q, 2); the frame is None if it is fixed.
    spring, dashpot
        Of the primary suspension, N/m and N s/m.
    """
    weights = np.zeros((len(rows), 3, len(boxes)))
    for row, weight in zip(rows, weights, strict=True):
        if isinstance(row, BoxMotion):
            weight[row.order] = boxes[:, row.wheel]
        elif isinstance(row, SuspensionReaction):
            relative = boxes[:, row.wheel] if frame is None else boxes[:, row.wheel] - frame[:, row.wheel]
            weight[0], weight[1] = spring * relative, dashpot * relative
    return weights


def point_weights(rows: Sequence[SensorRow], mesh: SectionMesh, n: int, modes: Real) -> Real:
    """Weights (S, 3, Q) of the rows of points, by modes (all unknowns, Q) of harmonic ``n``; zero for other rows."""
    weights = np.zeros((len(rows), 3, modes.shape[1]))
    for row, weight in zip(rows, weights, strict=True):
        if isinstance(row, PointMotion):
            node, _ = nearest_node(mesh, row.y, row.r)
            sign = (-1.0) ** n
            radial, around = modes[3 * node], modes[3 * node + 2]
            weight[row.order] += sign * cos(n * row.angle) * cos(row.angle) * radial
            weight[row.order] -= sign * sin(n * row.angle) * sin(row.angle) * around
    return weights


def strain_shapes(rows: Sequence[SensorRow], wheelset: Wheelset, mesh: SectionMesh, n: int) -> Real:
    """Strain (S, all unknowns), 1/m, that the rows of gauges read from displacements of harmonic ``n``."""
    found = np.zeros((len(rows), 3 * len(mesh.points)))
    material = wheelset.material
    nu = material.poissons_ratio
    hooke = np.array([-nu, 1.0, -nu, 0.0, 0.0, 0.0]) / material.youngs_modulus
    for row, shape in zip(rows, found, strict=True):
        if isinstance(row, AxialStrain) and row.n in (None, n):
            nodes, weights = on_axle(wheelset, mesh, row.y)
            stress = nodal_stress(mesh, material, n, nodes).toarray().reshape(len(nodes), 6, -1)
            turned = 1.0 if row.n is not None else (-1.0) ** n * cos(n * row.angle)
            shape[:] = turned * np.einsum("k,c,kcu->u", weights, hooke, stress)
    return found


def strain_rows(y: float) -> tuple[AxialStrain, ...]:
    """Amplitudes of all harmonics at ``y``, in their order: what a gauge that turns is made of."""
    return tuple(AxialStrain(y, n) for n in HARMONICS)


def strain_around(angles: Real) -> Real:
    """What the amplitudes of ``strain_rows`` count at ``angles`` (N,) from the top: (N, harmonics)."""
    n = np.array(HARMONICS)
    turned: Real = (-1.0) ** n * np.cos(n * angles[:, np.newaxis])
    return turned


def nearest_node(mesh: SectionMesh, y: float, r: float) -> tuple[int, float]:
    """Node of the section's mesh nearest to a place, and how far it is, m."""
    distances = np.hypot(*(mesh.points - (y, r)).T)
    node = int(distances.argmin())
    return node, float(distances[node])
