"""Finite elements of one bay of a half track: the cell that both the finite track and the ring repeat (Section 4).

Half a track. The track is symmetric about its centre. Forces F_1 and F_2 on its rails are the sum of a symmetric load,
(F_1 + F_2) / 2 on both, and an antisymmetric one, (F_1 - F_2) / 2 on rail 1 and its negative on rail 2. Each is solved
on one rail and half a sleeper. At the centre of the sleeper the rotation is zero in the symmetric half, the deflection
in the antisymmetric one.

A cell. It has n unknowns: the half sleeper's, then ``[w, theta]`` of the rail nodes from above its sleeper to the last
one before the next sleeper. Local matrices A over the cell and the first rail node of the next cell, (n + 2,
n + 2), have the blocks A_uu, A_un, A_nn. Put together, with u_k the unknowns of cell k::

    (A u)_k = A_0 u_k + A_1 u_{k+1} + A_1^T u_{k-1},     A one of M, C, K
    A_0 = A_uu + A_nn on the cell's own first rail node,     A_1 = A_un on that of the next cell

The pad between sleeper and rail has the compression w - seat.u_sleeper. It turns with the rail above a sleeper that
does not turn (Eqs (20), (21)). The ballast acts at each node of the sleeper with the share l / L of its stiffness and
damping, where l is the node's tributary length and L the sleeper's length.

Accuracy: elements with consistent mass (``timoshenko``), whose nodal statics are exact. The reduced cell
(``reduce_bay``) keeps statics as they are, and the rail's modes between two sleepers up to its number of modes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from ..errors import InputError
from ..runtime.arrays import Complex, Real
from .timoshenko import element_matrices, local_flexibility, shape_functions
from .track import Half, Track


@dataclass(frozen=True, eq=False)
class HalfSleeper:
    """Half a sleeper on ballast with the condition of its half track at the centre.

    Its dynamic stiffness is ``K + i omega C - omega^2 M``.
    """

    mass: Real  # (n, n)
    damping: Real  # (n, n)
    stiffness: Real  # (n, n)
    seat: Real  # (n,) shape functions at the rail seat

    def receptance(self, omega: NDArray[Any]) -> Complex:
        """Receptance (...,) at the rail seat, m/N, at ``omega`` (rad/s), from the poles of the half sleeper.

        The state [u, u'] has poles p and shapes; the receptance is the sum of residue / (i omega - p).
        """
        n = self.seat.size
        inverse = np.linalg.inv(self.mass)
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ self.stiffness, -inverse @ self.damping]])
        poles, shapes = np.linalg.eig(state)
        load = np.concatenate([np.zeros(n), inverse @ self.seat])
        residues = (self.seat @ shapes[:n]) * np.linalg.solve(shapes, load.astype(complex))
        total = np.zeros(np.shape(omega), dtype=np.complex128)
        for pole, residue in zip(poles, residues, strict=True):
            total += residue / (1j * np.asarray(omega) - pole)
        return total


def half_sleeper(track: Track, half: Half) -> HalfSleeper:
    """Finite elements of the sleeper from its centre (no rotation, or no deflection, there) to its free end.

    Ballast acts at the nodes by tributary length. A rail seat between nodes has the shape functions there. On slab
    track there are no unknowns.
    """
    sleeper, ballast = track.sleeper, track.ballast
    if sleeper is None or ballast is None:
        none = np.zeros((0, 0))
        return HalfSleeper(none, none, none, np.zeros(0))
    elements = sleeper.elements // 2
    length = sleeper.length / sleeper.elements
    k, m = element_matrices(sleeper, length)
    size = 2 * (elements + 1)
    mass, damping, stiffness = np.zeros((3, size, size))
    share = np.full(elements + 1, length / sleeper.length)
    share[[0, -1]] /= 2.0
    for element in range(elements):
        at = slice(2 * element, 2 * element + 4)
        stiffness[at, at] += k
        mass[at, at] += m
    deflections = np.arange(0, size, 2)
    stiffness[deflections, deflections] += share * ballast.stiffness
    damping[deflections, deflections] += share * ballast.damping
    seat = np.zeros(size)
    element = min(int(track.rail_distance / 2.0 / length + 1e-9), elements - 1)
    s = track.rail_distance / 2.0 / length - element
    seat[2 * element : 2 * element + 4] = shape_functions(sleeper, length, np.array(s))[0]
    free = np.delete(np.arange(size), 1 if half == "symmetric" else 0)
    inner = np.ix_(free, free)
    return HalfSleeper(mass[inner], damping[inner], stiffness[inner], seat[free])


@dataclass(frozen=True, eq=False)
class Bay:
    """Matrices of a half track's cell over its own unknowns and the next cell's first rail node: (n + 2, n + 2).

    ``basis`` gives the finite-element unknowns from these; it is the identity unless the cell has been reduced.
    """

    track: Track
    mass: Real
    damping: Real
    stiffness: Real
    basis: Real
    elements: int  # rail elements
    below: int  # unknowns of the half sleeper; those of the first rail node follow

    @property
    def size(self) -> int:
        """Number n of unknowns of a cell."""
        return int(self.mass.shape[0]) - 2

    def cell(self, local: Real) -> tuple[Real, Real]:
        """``A_0`` and ``A_1``, each (n, n), of a matrix over the cell and the next cell's first node."""
        n, first = self.size, slice(self.below, self.below + 2)
        own, ahead = local[:n, :n].copy(), np.zeros((n, n))
        own[first, first] += local[n:, n:]
        ahead[:, first] = local[:n, n:]
        return own, ahead

    def shapes(self, x: Real) -> tuple[Real, Real]:
        """Shape functions at ``x`` (m,) in [0, spacing]: rows (m, n) for the own cell and for the next one.

        They give the deflection there from the unknowns, and the unknowns' share of a load there.
        """
        x = np.asarray(x, dtype=np.float64)
        element, s = self._element(x)
        w, _ = shape_functions(self.track.rail, self.track.spacing / self.elements, s)
        rows = np.zeros((x.size, self.basis.shape[0]))
        columns = self.below + 2 * element[:, None] + np.arange(4)
        np.put_along_axis(rows, columns, w, axis=1)
        rows = rows @ self.basis
        ahead = np.zeros((x.size, self.size))
        ahead[:, self.below : self.below + 2] = rows[:, self.size :]
        return rows[:, : self.size], ahead

    def local(self, x_load: Real, x_response: Real) -> Real:
        """Flexibility of a load inside an element, m/N, for positions in the same bay; 0 if not in the same element."""
        load, s_load = self._element(np.asarray(x_load, dtype=np.float64))
        response, s_response = self._element(np.asarray(x_response, dtype=np.float64))
        length = self.track.spacing / self.elements
        inside = local_flexibility(self.track.rail, length, s_load * length, s_response * length)
        return np.where(load == response, inside, 0.0)

    def _element(self, x: Real) -> tuple[NDArray[np.int64], Real]:
        if np.any((x < -1e-9) | (x > self.track.spacing + 1e-9)):
            raise InputError(f"x is not inside the bay: give positions from 0 to {self.track.spacing:g} m")
        length = self.track.spacing / self.elements
        element = np.clip((x / length + 1e-9).astype(np.int64), 0, self.elements - 1)
        return element, x / length - element


def assemble_bay(track: Track, half: Half, elements: int | None = None) -> Bay:
    """Cell of a half track: the half sleeper, the rail to the next sleeper, and the pad between them.

    ``elements`` is the number of rail elements; the default is the track's own.
    """
    sleeper = half_sleeper(track, half)
    count = elements or track.rail.elements_per_bay
    below = sleeper.seat.size
    size = below + 2 * count + 2
    k, m = element_matrices(track.rail, track.spacing / count)
    mass, damping, stiffness = np.zeros((3, size, size))
    for element in range(count):
        at = slice(below + 2 * element, below + 2 * element + 4)
        stiffness[at, at] += k
        mass[at, at] += m
    mass[:below, :below] += sleeper.mass
    damping[:below, :below] += sleeper.damping
    stiffness[:below, :below] += sleeper.stiffness
    across = np.concatenate([-sleeper.seat, [1.0]])  # compression of the pad
    pad, turn = slice(below + 1), below + 1
    stiffness[pad, pad] += track.pad.stiffness * np.outer(across, across)
    damping[pad, pad] += track.pad.damping * np.outer(across, across)
    stiffness[turn, turn] += track.pad.rotational_stiffness
    damping[turn, turn] += track.pad.rotational_damping
    return Bay(track, mass, damping, stiffness, np.eye(size), count, below)


def reduce_bay(bay: Bay, modes: int) -> Bay:
    """Replace the rail between two sleepers by its static shapes and its lowest ``modes`` modes with held ends.

    The inner unknowns u_i follow the others, u_b, as u_i = -K_ii^-1 K_ib u_b + Phi eta, with the modes
    K_ii Phi = M_ii Phi diag(omega^2) of the rail whose ends are held. K then has no coupling between u_b and eta, so
    statics stay as exact as they were (R. R. Craig and M. C. C. Bampton, AIAA Journal 6 (1968) 1313-1319).
    """
    size = bay.mass.shape[0]
    inner = np.arange(bay.below + 2, size - 2)
    border = np.concatenate([np.arange(bay.below + 2), [size - 2, size - 1]])
    K_ii, M_ii = bay.stiffness[np.ix_(inner, inner)], bay.mass[np.ix_(inner, inner)]
    _, shapes = eigh(K_ii, M_ii, subset_by_index=(0, modes - 1))
    static = -np.linalg.solve(K_ii, bay.stiffness[np.ix_(inner, border)])
    basis = np.zeros((size, bay.below + 2 + modes + 2))
    kept = np.concatenate([np.arange(bay.below + 2), bay.below + 2 + modes + np.arange(2)])
    basis[border, kept] = 1.0
    basis[np.ix_(inner, kept)] = static
    basis[inner, bay.below + 2 : bay.below + 2 + modes] = shapes
    mass, damping, stiffness = (basis.T @ a @ basis for a in (bay.mass, bay.damping, bay.stiffness))
    return replace(bay, mass=mass, damping=damping, stiffness=stiffness, basis=bay.basis @ basis)
