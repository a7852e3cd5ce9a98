"""Influence lines of the infinite track: what a fixed place reads for a unit force anywhere, by reciprocity.

A reading R at the place x_d is a row of the rail's state y = [w, theta, Q, M] there, R = l . y(x_d). Let y be the state
under a unit force at X, and y' the state without load but with a jump J at x_d. Along the rail the products
``w Q' - w' Q + theta M' - theta' M`` of two states are constant, supports keep them, and both states decay. The force
makes Q jump by -1, so what is left of the sum over the line is ``w'(X) + w J_Q - Q J_w + theta J_M - M J_theta = 0``
with y at x_d. The jump that belongs to a row l is therefore::

    J = [l_Q, l_M, -l_w, -l_theta],        R(X) = w'(X)

The influence line is the deflection of a state that is homogeneous but for J. So in each bay it is the first row of the
transfer matrix times one state, for which the one in the middle of the bay is taken: the least digits are lost there.
In the bay of x_d there are two such states, one on either side. Sleepers move as ``BlochTrack.node`` says for the
shares ``l . T(s)`` of the load on the two ends of that bay.

A force at X that stands exactly at x_d reads the mean of both sides.

Source: derived here, from Betti's theorem for beams on elastic supports.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Complex
from .bay import half_sleeper
from .bloch import BlochTrack
from .timoshenko import deflection_row, transfer_matrix
from .track import Half

Quantity = Literal["deflection", "shear", "moment", "seat_force", "sleeper_deflection"]
"""Deflections in m and positive downwards, shear Q = kGA (w' - theta) in N, moment M = EI theta' in N m, the force from
the rail on its seat in N, positive in compression."""
ROWS = {"deflection": 0, "shear": 2, "moment": 3}
"""Readings of the rail, and their entry of the state."""


@dataclass(frozen=True, eq=False)
class InfluenceLine:
    """Reading at one place for unit forces in bays from ``first`` on, at the frequencies of a half track."""

    waves: BlochTrack
    first: int
    place: float
    """Of the reading in bay 0, m."""
    before: Complex  # (bays, 4, f) states in the middle of the bays, of the part before the place in bay 0
    behind: Complex  # (4, f) state in the middle of bay 0, of the part behind the place

    def at(self, bay: int, x: float) -> Complex:
        """Reading (f,) for a unit force at ``x`` m in a bay."""
        row = deflection_row(self.waves.track.rail, self.waves.omega, x - self.waves.track.spacing / 2).T
        before = self.before[bay - self.first]
        if bay or x < self.place - 1e-9:
            state = before
        elif x > self.place + 1e-9:
            state = self.behind
        else:
            state = (before + self.behind) / 2.0
        return np.asarray(np.sum(row * state, axis=0), dtype=np.complex128)


def influence_line(
    waves: BlochTrack, half: Half, quantity: Quantity, place: float, first: int, last: int
) -> InfluenceLine:
    """Influence line of a reading at ``place`` m in bay 0, for forces in the bays ``first`` to ``last``.

    Forces on seats, and sleepers at the seats, are those of the sleeper at the beginning of the bay; ``place`` is 0.
    """
    track, omega = waves.track, waves.omega
    length, nodes = track.spacing, range(first, last + 2)
    jump: NDArray[Any] = np.zeros((4, omega.size))
    shares: NDArray[Any] = np.zeros((4, omega.size), dtype=np.complex128)
    if quantity in ROWS:
        entry = ROWS[quantity]
        row = transfer_matrix(track.rail, omega, place)[:, entry]
        ends = np.einsum("fs,fsu->fu", row[:, 2:], waves.to_state)
        shares[:2] = (row[:, :2] - np.einsum("fv,fvu->fu", ends, waves.across)).T
        shares[2:] = ends.T
        jump[(entry + 2) % 4] = -1.0 if entry < 2 else 1.0
    else:
        pad = track.pad.stiffness + 1j * omega * track.pad.damping
        give = half_sleeper(track, half).receptance(omega)
        shares[0] = 1.0 / (1.0 / pad + give)
        if quantity == "sleeper_deflection":
            shares[0] *= give
    u = np.stack([waves.node(node, shares) for node in nodes])  # (nodes, 2, f)
    over = np.einsum("fst,tf->sf", transfer_matrix(track.rail, omega, length - place), jump)[:2]
    back = np.einsum("fst,tf->sf", transfer_matrix(track.rail, omega, -place), jump)
    ahead = u[1:] - np.einsum("fuv,nvf->nuf", waves.across, u[:-1])
    ahead[-first] -= over
    state = np.concatenate([u[:-1], np.einsum("fsu,nuf->nsf", waves.to_state, ahead)], axis=1)
    middle = transfer_matrix(track.rail, omega, length / 2)
    before: Complex = np.einsum("fst,ntf->nsf", middle, state)
    behind: Complex = np.einsum("fst,tf->sf", middle, state[-first] + back)
    return InfluenceLine(waves, first, place, before, behind)
