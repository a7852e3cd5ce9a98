"""Receptances of the infinite track by Bloch waves: exact, and vectorised over frequency (Section 4, Fig. 7).

Rail of a bay. The beam's harmonic solution [w, theta, Q, M] over a bay of length l is y(l) = T y(0), without elements
(``timoshenko.transfer_matrix``). With the 2 x 2 blocks T_11, T_12 of T, the loads on both ends are D u::

    D_11 = T_12^-1 T_11,    D_12 = -T_12^-1,    u = [w, theta]   (m, rad),   loads [force, moment]   (N, N m)

The bay is its own mirror image, w(-x) = w(x) and theta(-x) = -theta(x). So D_22 is D_11 with the signs of its
off-diagonal entries turned, and D_12 = [a, b; -b, d] = D_21^T.

Supports. A pad in series with half a sleeper has the stiffness S_w = 1 / (1 / (k + i omega c) + receptance), N/m.
Against rotation the pad has S_theta = k_rot + i omega c_rot, N m (Eqs (20), (21)). With P = 2 (D_11)_ww + S_w and
R = 2 (D_11)_tt + S_theta, the rail above the sleepers n obeys::

    D_12^T u_{n-1} + diag(P, R) u_n + D_12 u_{n+1} = f_n

Waves. Without load u_n = z^n v gives two homogeneous equations. Their determinant is a quadratic in mu = z + 1/z::

    [ P + a mu         b (z - 1/z) ]
    [ -b (z - 1/z)     R + d mu    ] v = 0,      (P + a mu) (R + d mu) + b^2 (mu^2 - 4) = 0

Each mu has one z with |z| <= 1: two waves decay towards +x, and their mirror images towards -x.

Loads. A unit force at sleeper 0 causes no rotation there, a unit moment no deflection. With the two waves ahead and
their mirror images behind, that condition and the balance at the sleeper give both amplitudes (``_amplitudes``). A load
inside a bay reaches its two ends in shares, which are the shape functions there (reciprocity). In its own bay the
deflection of the rail with both ends held is added (``BlochTrack._local``).

Accuracy: exact for the model, up to rounding. Over a bay of 0.6 m the transfer matrix keeps 12 digits at 5 kHz and 6 at
10 kHz. Cost: one small system for each frequency, and one product for each response.

Source: derived here; Bloch (Floquet) waves of a periodic structure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..runtime.arrays import Complex
from .bay import half_sleeper
from .timoshenko import deflection_row, transfer_matrix
from .track import HALVES, Half, Track

MAX_FREQUENCY = 1e4
"""Highest frequency in Hz: beyond it the transfer matrix of a bay loses digits."""


def receptance(track: Track, frequencies: ArrayLike, x_load: float, x_response: ArrayLike) -> tuple[Complex, Complex]:
    """Direct and cross receptance, each (responses, frequencies) in m/N: response on the loaded and the opposite rail.

    ``frequencies`` in Hz, 0 included; positions in m anywhere along the track, with a sleeper at 0. For long tables
    keep the two ``BlochTrack`` and ask them for blocks of responses. Raises InputError for frequencies out of range.
    """
    symmetric, antisymmetric = (bloch_track(track, half, frequencies).receptance(x_load, x_response) for half in HALVES)
    return (symmetric + antisymmetric) / 2.0, (symmetric - antisymmetric) / 2.0


@dataclass(frozen=True, eq=False)
class BlochTrack:
    """A half track at given frequencies: its decaying waves and the response of all sleepers' rail points to a load."""

    track: Track
    omega: NDArray[Any]  # (f,) rad/s, complex if the frequencies are
    factors: Complex  # (2, f) z of the two waves, |z| <= 1: the change from one bay to the next
    waves: Complex  # (2, 2, f) [unknown, wave]: v = [w, theta] of the wave that runs towards +x
    amplitudes: Complex  # (2, 2, f) [wave, load]: of the waves for a unit force and a unit moment at a sleeper
    to_state: NDArray[Any]  # (f, 2, 2) inverse of the block of a bay's transfer matrix from [Q, M] to [w, theta]
    across: NDArray[Any]  # (f, 2, 2) the block from [w, theta] to [w, theta]

    def receptance(self, x_load: float, x_response: ArrayLike) -> Complex:
        """Deflection (responses, frequencies) at ``x_response`` for a unit force at ``x_load``, m/N."""
        x = np.atleast_1d(np.asarray(x_response, dtype=np.float64))
        length = self.track.spacing
        load_bay, inside = _place(x_load, length)
        shares = self.interpolation(inside)
        result = np.empty((x.size, self.omega.size), dtype=np.complex128)
        nodes: dict[int, Complex] = {}
        for i, position in enumerate(x):
            bay, s = _place(float(position), length)
            for node in (bay - load_bay, bay - load_bay + 1):
                if node not in nodes:
                    nodes[node] = self.node(node, shares)
            near, far = nodes[bay - load_bay], nodes[bay - load_bay + 1]
            row = self.interpolation(s)
            result[i] = row[0] * near[0] + row[1] * near[1] + row[2] * far[0] + row[3] * far[1]
            if bay == load_bay:
                result[i] += self._local(min(inside, s), max(inside, s))
        return result

    def interpolation(self, x: float) -> NDArray[Any]:
        """Exact dynamic shape functions (4, f) at ``x`` in a bay: its deflection from ``[w, theta]`` at both ends.

        By reciprocity they are also the shares of a load at ``x`` that reach the two ends.
        """
        row = deflection_row(self.track.rail, self.omega, x)
        ahead = np.einsum("fs,fsu->fu", row[:, 2:], self.to_state)
        behind = row[:, :2] - np.einsum("fv,fvu->fu", ahead, self.across)
        shares: NDArray[Any] = np.concatenate([behind, ahead], axis=1).T
        return shares

    def node(self, node: int, shares: NDArray[Any]) -> Complex:
        """``[w, theta]`` (2, f) at sleeper ``node`` for a load in bay 0 with ``shares`` (4, f) on its two ends."""
        u = np.zeros((2, self.omega.size), dtype=np.complex128)
        for end in range(2):
            distance = node - end
            mirror = np.array([1.0, -1.0])[:, None] if distance < 0 else np.ones((2, 1))
            # the field behind a load is the mirror image of the field ahead of the mirrored load
            load = shares[2 * end : 2 * end + 2] * mirror
            for wave in range(2):
                amplitude = np.sum(self.amplitudes[wave] * load, axis=0) * self.factors[wave] ** abs(distance)
                u += mirror * self.waves[:, wave] * amplitude
        return u

    def _local(self, low: float, high: float) -> NDArray[Any]:
        """Deflection (f,) at one of two positions of a bay, its ends held, for a unit force at the other."""
        length = self.track.spacing
        rail = self.track.rail
        # Behind the load the state jumps by -1 in Q; the ends are brought back to rest by the shape functions.
        jump = transfer_matrix(rail, self.omega, length - low)[:, :2, 2]
        right = self.interpolation(high)[2:]
        local: NDArray[Any] = right[0] * jump[:, 0] + right[1] * jump[:, 1]
        local -= deflection_row(rail, self.omega, high - low)[:, 2]
        return local


def bloch_track(track: Track, half: Half, frequencies: ArrayLike) -> BlochTrack:
    """Bloch waves of a half track at ``frequencies`` in Hz; raises InputError if one is not in 0 to 10 kHz.

    Complex frequencies with a negative imaginary part are those of motion that decays, and waves decay faster there.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies))
    if not np.all((frequencies.real >= 0.0) & (frequencies.real <= MAX_FREQUENCY) & (frequencies.imag <= 0.0)):
        raise InputError(f"frequencies are out of range: give 0 to {MAX_FREQUENCY:g} Hz")
    omega = 2.0 * np.pi * frequencies
    T = transfer_matrix(track.rail, omega, track.spacing)
    to_state: NDArray[Any] = np.linalg.inv(T[:, :2, 2:])
    across = T[:, :2, :2]
    D_11, D_12 = to_state @ across, -to_state
    pad = track.pad.stiffness + 1j * omega * track.pad.damping
    turn = track.pad.rotational_stiffness + 1j * omega * track.pad.rotational_damping
    support = 1.0 / (1.0 / pad + half_sleeper(track, half).receptance(omega))
    P: Complex = 2.0 * D_11[:, 0, 0] + support
    R: Complex = 2.0 * D_11[:, 1, 1] + turn
    a, b, d = D_12[:, 0, 0], D_12[:, 0, 1], D_12[:, 1, 1]

    # (P + a mu)(R + d mu) + b^2 (mu^2 - 4) = 0 with mu = z + 1/z
    mu = _roots((a * d + b**2).astype(np.complex128), P * d + R * a, P * R - 4.0 * b**2)
    z = 1.0 / _roots(np.ones_like(mu[0]), -mu, np.ones_like(mu[0]))[0]

    # either row of the 2 x 2 problem gives the wave's shape; take the longer one
    first, second = np.array([b * (1.0 / z - z), P + a * mu]), np.array([R + d * mu, b * (z - 1.0 / z)])
    waves = np.where(np.abs(first).sum(axis=0) >= np.abs(second).sum(axis=0), first, second)
    waves = waves / np.sqrt(np.sum(np.abs(waves) ** 2, axis=0))
    return BlochTrack(track, omega, z, waves, _amplitudes(P, R, a, b, d, z, waves), to_state, across)


def _amplitudes(
    P: Complex, R: Complex, a: NDArray[Any], b: NDArray[Any], d: NDArray[Any], z: Complex, waves: Complex
) -> Complex:
    """Amplitudes (2, 2, f) [wave, load] of the waves ahead of a unit force and a unit moment at a sleeper.

    A force leaves no rotation at its sleeper, a moment no deflection; the waves behind are their mirror images.
    """
    w, theta = waves
    force = P * w + 2.0 * z * (a * w + b * theta)
    moment = R * theta + 2.0 * z * (d * theta - b * w)
    by_force = np.array([theta[1], -theta[0]]) / (force[0] * theta[1] - force[1] * theta[0])
    by_moment = np.array([w[1], -w[0]]) / (moment[0] * w[1] - moment[1] * w[0])
    return np.stack([by_force, by_moment], axis=1)


def _roots(a: Complex, b: Complex, c: Complex) -> Complex:
    """Both roots (2, ...) of ``a x^2 + b x + c``, the larger first, without cancellation."""
    root = np.sqrt(b**2 - 4.0 * a * c + 0j)
    q = -(b + np.where((np.conj(b) * root).real >= 0.0, root, -root)) / 2.0
    return np.array([q / a, c / q])


def _place(x: float, length: float) -> tuple[int, float]:
    bay = int(np.floor(x / length + 1e-9))
    return bay, max(x - bay * length, 0.0)
