"""Bloch modes of a ring of bays, wavenumber by wavenumber, and which of them count.

``track_ring`` explains what they are for. Poles in rad/s, wavenumbers in rad/m, receptances in m/N.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Complex, Real
from .bay import Bay

Mask = NDArray[np.bool_]


class RingModes(NamedTuple):
    """P modes with tables over the nb positions of a bay; the phase ``exp(i kappa x)`` is taken out of them."""

    poles: Complex  # (P,)
    wavenumbers: Real  # (P,)
    input: Complex  # (nb, P)
    output: Complex  # (nb, P)

    def at(self, kept: Mask) -> RingModes:
        """The modes at ``kept`` (P,) alone."""
        return RingModes(self.poles[kept], self.wavenumbers[kept], self.input[:, kept], self.output[:, kept])

    def dynamic(self, omega: Real) -> Complex:
        """What the modes add to the direct receptance beyond their statics: (f, about 24 positions of the bay)."""
        up, down = _beyond_statics(self.poles, omega)
        gain = self.input[_few(self.input)] * self.output[_few(self.input)]
        both: Complex = (up @ gain.T + down @ gain.conj().T) / 2.0
        return both


def _matrix(bay: Bay, local: Real, phase: complex) -> Complex:
    """Matrix (n, n) of a wave that changes by ``phase`` from one bay to the next."""
    own, ahead = bay.cell(local)
    matrix: Complex = own + ahead * phase + ahead.T / phase
    return matrix


def static_compliance(bay: Bay, shapes: tuple[Real, Real], kappa: float) -> Real:
    """Static compliance (nb,) m/N of a wavenumber; its mean over all wavenumbers is that at one point of the ring."""
    phase = np.exp(1j * kappa * bay.track.spacing)
    rows = shapes[0] + shapes[1] * phase
    compliance: Real = np.sum(rows.T * np.linalg.solve(_matrix(bay, bay.stiffness, phase), rows.conj().T), axis=0).real
    return compliance


def bloch_modes(bay: Bay, shapes: tuple[Real, Real], x: Real, kappa: float, limit: float) -> RingModes:
    """Modes with ``|lambda| < limit`` at a wavenumber: their part in a ring is one over its bays.

    Left eigenvectors are the rows of the inverse of the matrix of right ones, which also holds where eigenvalues
    coincide, as they do at both ends of the zone.
    """
    n = bay.size
    phase = np.exp(1j * kappa * bay.track.spacing)
    M, C, K = (_matrix(bay, local, phase) for local in (bay.mass, bay.damping, bay.stiffness))
    scale = np.sqrt(np.linalg.norm(K) / np.linalg.norm(M))  # velocities in the size of deflections
    system = np.block([[np.zeros((n, n)), scale * np.eye(n)], [-np.linalg.solve(M, K) / scale, -np.linalg.solve(M, C)]])
    poles, right = np.linalg.eig(system)
    left = np.linalg.inv(right)
    low = np.abs(poles) < limit
    rows = shapes[0] + shapes[1] * phase
    along = np.exp(1j * kappa * x)[:, None]
    inputs = (left[low, n:] @ np.linalg.solve(M, rows.conj().T)).T / scale * along
    outputs = (rows @ right[:n, low]) / along
    return RingModes(poles[low], np.full(low.sum(), kappa), inputs, outputs)


def real_form(modes: RingModes, own_mirror: bool, bays: int) -> RingModes:
    """Modes of a ring whose real part is the whole response: those of ``-kappa`` are the conjugates of ``kappa``'s.

    ``own_mirror`` says that ``kappa`` and ``-kappa`` are the same wave of the ring.
    """
    weight = np.full(modes.poles.size, 2.0 / bays)
    if own_mirror:
        real = np.abs(modes.poles.imag) <= 1e-9 * np.abs(modes.poles)
        weight[real] = 1.0 / bays
        kept = real | (modes.poles.imag > 0.0)
        modes, weight = modes.at(kept), weight[kept]
    poles, wavenumbers, inputs, outputs = modes
    turn = poles.imag < 0.0
    return RingModes(
        np.where(turn, poles.conj(), poles),
        np.where(turn, -wavenumbers, wavenumbers),
        np.where(turn, inputs.conj(), inputs),
        np.where(turn, outputs.conj(), outputs) * weight,
    )


def response_level(modes: RingModes, static: Real, omega: Real) -> Real:
    """Root mean square (f,) over the bay of the direct receptance, from all modes and the ``static`` one (nb,)."""
    level: Real = np.sqrt(np.mean(np.abs(static[_few(static)] + modes.dynamic(omega)) ** 2, axis=1))
    return level


def thinned(modes: RingModes, bays: int, spacing: float, omega: Real, level: Real, tolerance: float) -> RingModes:
    """Modes with every second wavenumber where that is enough: for the damped waves of sleepers on ballast.

    The sum over wavenumbers is a trapezoidal rule, and its error what comes round the ring. Modes that keep apart
    from all others at every wavenumber are such a sum of their own, and a ring of half the ``bays`` serves them if
    that changes the receptance by less than ``tolerance level`` (f,). A quarter errs by 0.5 um of 1.1 mm: the load
    itself runs some metres before these waves have died out.
    """
    modulus = np.sort(np.abs(modes.poles))
    apart = modulus[np.argmax(modulus[1:] / modulus[:-1])]
    group = np.abs(modes.poles) <= apart
    index = np.rint(np.abs(modes.wavenumbers) * spacing * bays / (2.0 * np.pi)).astype(np.int64)
    half = group & (index % 2 == 0)
    thin = modes._replace(output=np.where(group, 2.0 * modes.output, modes.output))
    change = np.abs(thin.at(half).dynamic(omega) - modes.at(group).dynamic(omega)).max(axis=1)
    if bays % 2 or np.max(change / level) > tolerance:
        return modes
    return thin.at(half | ~group)


def counting(modes: RingModes, omega: Real, level: Real, tolerance: float) -> Mask:
    """Modes (P,) that count: those left out change no receptance by more than ``tolerance level`` (f,), all together.

    Their static part is not lost to the response, so the bound is on the rest.
    """
    up, down = _beyond_statics(modes.poles, omega)
    bound = np.abs(modes.input).max(axis=0) * np.abs(modes.output).max(axis=0)
    share = bound * (np.abs(up) + np.abs(down)) / 2.0 / level[:, None]
    order = np.argsort(share.max(axis=0))
    kept = np.empty(modes.poles.size, dtype=bool)
    kept[order] = np.cumsum(share[:, order], axis=1).max(axis=0) > tolerance
    return kept


def _beyond_statics(poles: Complex, omega: Real) -> tuple[Complex, Complex]:
    """``1 / (i omega - lambda) + 1 / lambda`` (f, P) of the poles and of their conjugates."""
    s = 1j * omega[:, None]
    return s / (poles * (s - poles)), s / (poles.conj() * (s - poles.conj()))


def _few(table: Real | Complex) -> slice:
    return slice(None, None, max(1, len(table) // 24))
