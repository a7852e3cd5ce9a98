"""The track as a line of bays whose supports differ: reduced parts, what joins them, statics and receptances.

The parts are the same in every bay, and reduced once. The rail between two sleepers has the deflection and rotation
``[w, theta]`` of both ends and its lowest modes with held ends; what its higher modes deflect is kept as a static
residual. The whole sleeper has its lowest free modes and its static shapes under loads on the seats, each half of them
symmetric and antisymmetric. What may differ is between the parts: pads, and the ballast under either half of a sleeper
(that under its middle belongs to both).

Unknowns of a bay, in this order: ``w, theta`` of rail 1 and of rail 2 above its sleeper, the modes of rail 1 and of
rail 2 up to the next sleeper, the modes of the sleeper. All masses of modes are 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh, orth
from scipy.sparse.linalg import splu

from ..runtime.arrays import Complex, Real
from .supports import Along, SupportLine, along
from .timoshenko import element_matrices, local_flexibility, shape_functions
from .track import Beam, Track

RAIL_ELEMENTS = 64
"""Rail elements a bay before the reduction."""

RAIL_MODES = 4
"""Modes of the rail between two sleepers, up to 6.4 kHz for 60E1 at 0.6 m."""

SLEEPER_MODES = 4
"""Free modes of either half of the sleeper, rigid ones included; a static shape comes to them."""


@dataclass(frozen=True, eq=False)
class RailSpan:
    """One rail between two sleepers: unknowns of its ends ``[w, theta, w, theta]``, then m modes."""

    track: Track
    mass: Real  # (4, 4) of the ends
    coupling: Real  # (4, m) mass between ends and modes
    stiffness: Real  # (4, 4) of the ends
    modes: Real  # (m,) rad^2/s^2
    basis: Real  # (unknowns of the elements, 4 + m)

    def shapes(self, x: ArrayLike) -> Real:
        """Shape functions (positions, 4 + m) at ``x`` m from its first end."""
        x = np.atleast_1d(np.asarray(x, dtype=np.float64))
        length = self.track.spacing / RAIL_ELEMENTS
        element = np.clip((x / length + 1e-9).astype(np.int64), 0, RAIL_ELEMENTS - 1)
        rows = np.zeros((x.size, 2 * RAIL_ELEMENTS + 2))
        shapes = shape_functions(self.track.rail, length, x / length - element)[0]
        np.put_along_axis(rows, 2 * element[:, None] + np.arange(4), shapes, axis=1)
        return np.asarray(rows @ self.basis)

    def residual(self, x: ArrayLike, response: ArrayLike | None = None) -> Real:
        """Static deflection (positions,) m/N of the modes left out at ``x``, or at ``response`` for loads there."""
        x = np.atleast_1d(np.asarray(x, dtype=np.float64))
        y = x if response is None else np.atleast_1d(np.asarray(response, dtype=np.float64))
        whole = local_flexibility(self.track.rail, self.track.spacing, x, y)
        return np.asarray(whole - (self.shapes(x)[:, 4:] * self.shapes(y)[:, 4:] / self.modes).sum(axis=1))


@dataclass(frozen=True, eq=False)
class SleeperModes:
    """A sleeper without its ballast in s modes of mass 1, symmetric ones first; s is 0 on slab track."""

    stiffness: Real  # (s,) rad^2/s^2
    seats: Real  # (2, s) deflection at the seat of rail 1 and 2
    nodes: Real  # (nodes, s) deflection at the nodes on which the ballast acts
    shares: Real  # (2, nodes) of the ballast under the half of rail 1 and 2

    @property
    def ballast(self) -> Real:
        """Stiffness (2, s, s) of the ballast under either half for a unit stiffness under the whole sleeper."""
        return np.asarray(np.einsum("hn,ni,nj->hij", self.shares, self.nodes, self.nodes), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class TrackLine:
    """Parts of a line and the values of its supports, (bays, 2): each sleeper on the side of rail 1 and of rail 2."""

    track: Track
    span: RailSpan
    sleeper: SleeperModes
    pad_stiffness: Real  # N/m
    pad_damping: Real  # N s/m
    ballast_stiffness: Real  # N/m of a whole sleeper with that ballast
    ballast_damping: Real  # N s/m
    gap: Real  # m, NaN where the ballast holds both ways

    @property
    def bays(self) -> int:
        """Bays after which the line repeats."""
        return len(self.gap)

    @property
    def size(self) -> int:
        """Unknowns of a bay."""
        return 4 + 2 * len(self.span.modes) + len(self.sleeper.stiffness)

    def matrices(self, first: int = 0, bays: int | None = None) -> tuple[sp.csc_array, sp.csc_array, sp.csc_array]:
        """Mass, damping and stiffness of ``bays`` from ``first`` on, closed to a ring; all ballast holds both ways."""
        count = self.bays if bays is None else bays
        at = (first + np.arange(count)) % self.bays
        m, n = len(self.span.modes), self.size
        own = np.zeros((3, count, n, n))
        ahead = np.zeros((3, n, n))
        mass, damping, stiffness = own
        span = self.span
        for rail in range(2):
            ends, modes = slice(2 * rail, 2 * rail + 2), np.arange(4 + m * rail, 4 + m * rail + m)
            for all_bays, link, of_ends, of_modes in (
                (mass, ahead[0], span.mass, np.ones(m)),
                (stiffness, ahead[2], span.stiffness, span.modes),
            ):
                all_bays[:, ends, ends] += of_ends[:2, :2] + of_ends[2:, 2:]
                all_bays[:, modes, modes] += of_modes
                link[ends, ends] += of_ends[:2, 2:]
            mass[:, ends, modes] += span.coupling[:2]
            mass[:, modes, ends] += span.coupling[:2].T
            ahead[0, modes, ends] += span.coupling[2:].T
        sleeper = np.arange(4 + 2 * m, n)
        mass[:, sleeper, sleeper] += 1.0
        stiffness[:, sleeper, sleeper] += self.sleeper.stiffness
        for side in range(2):
            across = np.zeros(n)
            across[2 * side], across[4 + 2 * m :] = 1.0, -self.sleeper.seats[side]
            turn = np.zeros((n, n))
            turn[2 * side + 1, 2 * side + 1] = self.track.pad.length**2 / 12.0
            pad, ballast = np.outer(across, across) + turn, np.zeros((n, n))
            ballast[4 + 2 * m :, 4 + 2 * m :] = self.sleeper.ballast[side]
            for all_bays, pads, beds in (
                (stiffness, self.pad_stiffness, self.ballast_stiffness),
                (damping, self.pad_damping, self.ballast_damping),
            ):
                all_bays += pads[at, side, None, None] * pad + beds[at, side, None, None] * ballast
        ring = sp.csr_array((np.ones(count), (np.arange(count), (np.arange(count) + 1) % count)), shape=(count, count))
        M, C, K = (
            sp.csc_array(sp.block_diag(list(blocks)) + sp.kron(ring, link) + sp.kron(ring, link).T)
            for blocks, link in zip(own, ahead, strict=True)
        )
        return M, C, K

    def rows(self, x: ArrayLike, rail: int, first: int = 0, bays: int | None = None) -> sp.csr_array:
        """Rows (positions, unknowns) of ``matrices`` that give the deflection of ``rail`` (0 or 1) at ``x`` m."""
        count, m, n = (self.bays if bays is None else bays), len(self.span.modes), self.size
        bay, inside = self.places(x)
        near = (bay - first) % count * n
        far = (bay + 1 - first) % count * n
        ends = 2 * rail + np.arange(2)
        columns = np.concatenate(
            [near[:, None] + ends, far[:, None] + ends, near[:, None] + 4 + m * rail + np.arange(m)], axis=1
        )
        lines = np.repeat(np.arange(bay.size), 4 + m)
        return sp.csr_array((self.span.shapes(inside).ravel(), (lines, columns.ravel())), shape=(bay.size, count * n))

    def places(self, x: ArrayLike) -> tuple[NDArray[np.int64], Real]:
        """Bay and position in it, m, of positions ``x`` m along the line."""
        x = np.atleast_1d(np.asarray(x, dtype=np.float64))
        bay = np.floor(x / self.track.spacing + 1e-9).astype(np.int64)
        return bay, np.maximum(x - bay * self.track.spacing, 0.0)

    def receptance(self, frequencies: ArrayLike, load: tuple[int, float], response: tuple[int, float]) -> Complex:
        """Deflection (frequencies,) m/N at ``response`` for a unit force at ``load``: rail (0 or 1) and position, m.

        ``frequencies`` in Hz. All ballast holds both ways, closed to a ring.
        """
        M, C, K = self.matrices()
        force, row = (self.rows(x, rail).toarray()[0] for rail, x in (load, response))
        omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
        found = [row @ splu(sp.csc_array(K + 1j * w * C - w**2 * M)).solve(force.astype(complex)) for w in omega]
        (bay, at), (other, there) = self.places(load[1]), self.places(response[1])
        same = load[0] == response[0] and (bay[0] - other[0]) % self.bays == 0
        return np.array(found, dtype=np.complex128) + (self.span.residual(at, there)[0] if same else 0.0)

    def compliance(self, x: ArrayLike) -> Real:
        """Static deflection (positions, 2) m/N of rail 1 and 2 at ``x`` m, with a unit force on both rails there.

        Hanging sleepers count as if they lay on their ballast.
        """
        solve = splu(self.matrices()[2]).solve
        x = np.atleast_1d(np.asarray(x, dtype=np.float64))
        found = np.empty((x.size, 2))
        for part in (slice(first, first + 64) for first in range(0, x.size, 64)):
            rails = [self.rows(x[part], rail).toarray() for rail in range(2)]
            deflected = solve((rails[0] + rails[1]).T)
            found[part] = np.stack([(row * deflected.T).sum(axis=1) for row in rails], axis=1)
        return found + self.span.residual(self.places(x)[1])[:, None]

    def stiffness(self, x: ArrayLike) -> Real:
        """Static stiffness (positions, 2) N/m of rail 1 and 2 at ``x`` m, the same force on both of them.

        Hanging sleepers count as if they lay on their ballast.
        """
        return np.asarray(1.0 / self.compliance(x))


@lru_cache(maxsize=8)
def track_line(track: Track) -> TrackLine:
    """Line of a track; one without a ``line`` has the same supports everywhere."""
    multiples: Along = along(track.line or SupportLine())
    bay = replace(track, line=None)  # lines that differ in their supports have these in common
    nowhere = np.zeros_like(multiples.gap)
    return TrackLine(
        track=track,
        span=rail_span(bay),
        sleeper=sleeper_modes(bay),
        pad_stiffness=multiples.pad_stiffness * track.pad.stiffness,
        pad_damping=multiples.pad_damping * track.pad.damping,
        ballast_stiffness=multiples.ballast_stiffness * track.ballast.stiffness if track.ballast else nowhere,
        ballast_damping=multiples.ballast_damping * track.ballast.damping if track.ballast else nowhere,
        gap=multiples.gap,
    )


@lru_cache(maxsize=8)
def rail_span(track: Track) -> RailSpan:
    """Rail of a bay: static shapes of its ends and lowest modes with held ends (Craig and Bampton, as in ``bay``)."""
    K, M = _beam(track.rail, track.spacing, RAIL_ELEMENTS)
    size = len(K)
    ends, inner = np.array([0, 1, size - 2, size - 1]), np.arange(2, size - 2)
    basis = np.zeros((size, 4 + RAIL_MODES))
    basis[ends, range(4)] = 1.0
    basis[inner, :4] = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, ends)])
    modes, basis[inner, 4:] = eigh(
        K[np.ix_(inner, inner)], M[np.ix_(inner, inner)], subset_by_index=(0, RAIL_MODES - 1)
    )
    mass, stiffness = basis.T @ M @ basis, basis.T @ K @ basis
    return RailSpan(track, mass[:4, :4], mass[:4, 4:], stiffness[:4, :4], modes, basis)


@lru_cache(maxsize=8)
def sleeper_modes(track: Track) -> SleeperModes:
    """Free modes of the whole sleeper and its static shapes on the track's own ballast under loads on the seats."""
    sleeper, ballast = track.sleeper, track.ballast
    if sleeper is None or ballast is None:
        return SleeperModes(np.zeros(0), np.zeros((2, 0)), np.zeros((0, 0)), np.zeros((2, 0)))
    count = sleeper.elements
    K, M = _beam(sleeper, sleeper.length, count)
    length = sleeper.length / count
    share = np.full(count + 1, 1.0 / count)
    share[[0, -1]] /= 2.0
    side = (np.sign(np.arange(count + 1) - count / 2) + 1.0) / 2.0  # of rail 1; of the middle half
    bed = np.zeros(2 * count + 2)
    bed[::2] = share * ballast.stiffness
    seats = np.zeros((2, 2 * count + 2))
    for row, y in zip(seats, (track.rail_distance / 2, -track.rail_distance / 2), strict=True):
        place = (y + sleeper.length / 2) / length
        element = min(int(place + 1e-9), count - 1)
        row[2 * element : 2 * element + 4] = shape_functions(sleeper, length, np.array(place - element))[0]
    static = np.linalg.solve(K + np.diag(bed), seats.T)
    parts = []
    for sign in (1.0, -1.0):  # symmetric, antisymmetric
        mirror = np.kron(np.eye(count + 1)[::-1], np.diag([sign, -sign]))
        half = orth(np.eye(2 * count + 2) + mirror)
        _, free = eigh(half.T @ K @ half, half.T @ M @ half, subset_by_index=(0, SLEEPER_MODES - 1))
        basis = np.concatenate([half @ free, static[:, :1] + sign * static[:, 1:]], axis=1)
        _, shapes = eigh(basis.T @ K @ basis, basis.T @ M @ basis)
        parts.append(basis @ shapes)
    shapes = np.concatenate(parts, axis=1)
    stiffness = np.maximum((shapes * (K @ shapes)).sum(axis=0), 0.0)
    return SleeperModes(stiffness, seats @ shapes, shapes[::2], np.stack([side, 1.0 - side]) * share)


def _beam(beam: Beam, length: float, elements: int) -> tuple[Real, Real]:
    """Stiffness and mass (2 (elements + 1), ...) of a free beam, unknowns ``[w, theta]`` node by node."""
    k, m = element_matrices(beam, length / elements)
    stiffness, mass = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for element in range(elements):
        at = slice(2 * element, 2 * element + 4)
        stiffness[at, at] += k
        mass[at, at] += m
    return stiffness, mass
