"""Receptances of a finite track by finite elements, with clamped rail ends: the paper's model (Section 4).

Plain (one sparse factorisation a frequency and half track): the reference for ``bloch`` and ``track_ring``. In statics
the three are the same to rounding. In dynamics the elements miss the growth of the shear force inside them, so that
the square of a frequency is too high by ``rhoA omega^2 h^2 / (12 kGA)``: with the paper's eight elements a bay the
pinned-pinned frequency comes out 0.26 % high, and the error falls with the square of the element length ``h``.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu

from ..errors import InputError
from ..runtime.arrays import Complex, Real
from .bay import Bay, assemble_bay
from .track import HALVES, Track

BAYS = 140
"""Length of the paper's track in bays."""


def receptance(
    track: Track, frequencies: ArrayLike, x_load: float, x_response: ArrayLike, *, bays: int = BAYS
) -> tuple[Complex, Complex]:
    """Direct and cross receptance, each (responses, frequencies) in m/N: response on the loaded and the opposite rail.

    ``frequencies`` in Hz; positions in m, with the middle of the track, above a sleeper, at 0. Raises InputError for a
    position outside the track.
    """
    omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    x = np.atleast_1d(np.asarray(x_response, dtype=np.float64))
    symmetric, antisymmetric = (_half(assemble_bay(track, half), omega, x_load, x, bays) for half in HALVES)
    return (symmetric + antisymmetric) / 2.0, (symmetric - antisymmetric) / 2.0


def _half(bay: Bay, omega: Real, x_load: float, x: Real, bays: int) -> Complex:
    first = -(bays // 2)
    # Both ends are clamped: no node beyond the last cell, and the first cell loses its sleeper and first node.
    kept = np.arange(bay.below + 2, bays * bay.size)

    def matrix(local: Real) -> sp.csc_array:
        own, ahead = bay.cell(local)
        shift = sp.csr_array(np.eye(bays, k=1))
        whole = sp.kron(sp.csr_array(np.eye(bays)), own) + sp.kron(shift, ahead) + sp.kron(shift.T, ahead.T)
        return sp.csc_array(sp.csr_array(whole)[kept][:, kept])

    M, C, K = matrix(bay.mass), matrix(bay.damping), matrix(bay.stiffness)
    load = _rows(bay, np.array([x_load]), first, bays)[:, kept]
    rows = _rows(bay, x, first, bays)[:, kept]
    result = np.empty((x.size, omega.size), dtype=np.complex128)
    for i, w in enumerate(omega):
        u = splu(sp.csc_array(K + 1j * w * C - w**2 * M)).solve(load[0].astype(np.complex128))
        result[:, i] = rows @ u
    place, inside = _places(bay, x)
    load_place, load_inside = _places(bay, np.array([x_load]))
    flexibility = bay.local(np.broadcast_to(load_inside, inside.shape), inside)
    return result + np.where(place == load_place, flexibility, 0.0)[:, None]


def _places(bay: Bay, x: Real) -> tuple[NDArray[np.int64], Real]:
    """Bay and position in it, in m, of positions along the track."""
    place = np.floor(x / bay.track.spacing + 1e-9).astype(np.int64)
    return place, np.maximum(x - place * bay.track.spacing, 0.0)


def _rows(bay: Bay, x: Real, first: int, bays: int) -> Real:
    """Shape functions (x, unknowns of all cells) at positions along the track."""
    place, inside = _places(bay, x)
    cell = place - first
    if np.any((cell < 0) | (cell >= bays)):
        limit = -first * bay.track.spacing
        raise InputError(f"x is outside the finite track: give positions within {limit:g} m of its middle")
    own, ahead = bay.shapes(inside)
    rows = np.zeros((x.size, bays + 1, bay.size))
    rows[np.arange(x.size), cell] += own
    rows[np.arange(x.size), cell + 1] += ahead
    return rows[:, :bays].reshape(x.size, -1)
