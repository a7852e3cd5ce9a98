"""The track as a ring of bays, seen from a frame that runs along it: Bloch modes, endless running, bounded cost.

A ring of N bays has modes ``u(x) = p(x) exp(i kappa x)`` with ``p`` periodic over one bay and ``kappa`` a multiple of
``2 pi / (N L)``. Each wavenumber is one small eigenproblem of a bay. In a frame fixed to the track a mode with pole
``lambda`` that is loaded by ``F`` at ``X(t)`` obeys, and the deflection at ``x`` is::

    q' = lambda q + s(X) exp(-i kappa X) F,     xi(x) = Re sum_P p(x) exp(i kappa x) q  +  residual,

``s`` periodic over one bay too. With ``r = q exp(i kappa X)`` and ``X = v t + const`` the phases leave the tables::

    r' = (lambda + i kappa v) r + s(X) F,     xi(X) = Re sum_P p(X) r + residual(X) F.

So the tables ``input = s`` and ``output = p`` are indexed by the position in the bay alone (step mod ``nb``), the poles
in the moving frame are ``lambda + i kappa v``, and the step of ``simulation.hold`` is exact but for ``s(X) F`` taken
linear over one step. Nothing grows with the distance run, and a change of speed changes the poles, not the state.

The halves are driven by ``F_s = (F_1 + F_2) / 2`` and ``F_a = (F_1 - F_2) / 2``; ``xi_1 = xi_s + xi_a`` and
``xi_2 = xi_s - xi_a``.

Modes at ``|lambda| > 2 pi max_frequency`` and modes that hardly count are left out; the static deflection that they
would give is kept in ``residual``, so that statics are exact at every position.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import cache
from ..errors import InputError
from . import bay as bay_module
from . import timoshenko
from . import track as track_module
from .bay import Bay, assemble_bay, reduce_bay
from .track import HALVES, Half, Track

if TYPE_CHECKING:
    from typing_extensions import Self

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[str, float], None]

BAYS = 80
"""Default number of bays: after an impact that moves the rail by 1.1 mm, what comes round the ring is below 0.1 um."""

MAX_FREQUENCY = 5000.0
"""Default highest frequency of the modes, Hz: the rail's modes above it count little, and statically."""

RAIL_ELEMENTS = 64
"""Rail elements a bay before the reduction: frequencies within 2e-4 at 2500 Hz."""

RAIL_MODES = 12
"""Modes of the rail between two sleepers that the reduction keeps."""

TOLERANCE = 0.03
"""Bound on what modes left out as negligible add to the receptance; what they add in fact is some ten times less."""


@dataclass(frozen=True, eq=False)
class HalfRing:
    """Modes of the ring of a half track in the moving frame; P modes, nb positions a bay."""

    poles: Complex  # (P,) rad/s, Im >= 0: the real part of the sum over them is the whole response
    wavenumbers: Real  # (P,) rad/m
    input: Complex  # (nb, P) s(x) at x = j dx
    output: Complex  # (nb, P) p(x) at x = j dx, in m/N s with the scale of ``input``
    residual: Real  # (nb,) m/N

    def standing(self, force: float) -> Complex:
        """Modal state (P,) in equilibrium with ``force`` (N) standing above a sleeper, x = 0."""
        state: Complex = -self.input[0] * force / self.poles
        return state

    def moving_poles(self, speed: float) -> Complex:
        """Poles (P,) in rad/s in a frame that runs at ``speed`` (m/s)."""
        return self.poles + 1j * self.wavenumbers * speed

    def receptance(self, frequencies: ArrayLike, position: int) -> Complex:
        """Direct receptance (frequencies,) in m/N at ``position`` of the bay; ``frequencies`` in Hz."""
        omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequencies, dtype=np.float64))[:, None]
        gain = self.output[position] * self.input[position]
        both = gain / (1j * omega - self.poles) + gain.conj() / (1j * omega - self.poles.conj())
        total: Complex = both.sum(axis=1) / 2.0 + self.residual[position]
        return total


@dataclass(frozen=True, eq=False)
class TrackRing:
    """Reduced track for endless running: both halves, with tables at steps of ``dx`` along a bay of ``spacing``."""

    symmetric: HalfRing
    antisymmetric: HalfRing
    spacing: float  # m
    dx: float  # m
    bays: int
    max_frequency: float  # Hz

    def receptance(self, frequencies: ArrayLike, position: int) -> tuple[Complex, Complex]:
        """Direct and cross receptance (frequencies,) in m/N, both rails at ``position`` of the bay."""
        even, odd = (half.receptance(frequencies, position) for half in (self.symmetric, self.antisymmetric))
        return (even + odd) / 2.0, (even - odd) / 2.0

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays that make up the ring, by name."""
        arrays: dict[str, np.ndarray] = {"scale": np.array([self.spacing, self.dx, self.bays, self.max_frequency])}
        for name in HALVES:
            half: HalfRing = getattr(self, name)
            arrays |= {f"{name}_{field.name}": getattr(half, field.name) for field in fields(half)}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Ring from its arrays; raises KeyError or ValueError if they are not those of a ring."""
        spacing, dx, bays, max_frequency = (float(value) for value in arrays["scale"])
        halves = [HalfRing(**{f.name: arrays[f"{name}_{f.name}"] for f in fields(HalfRing)}) for name in HALVES]
        for half in halves:
            shape = (round(spacing / dx), half.poles.size)
            if half.input.shape != shape or half.output.shape != shape or half.residual.shape != shape[:1]:
                raise ValueError(f"tables of the ring are not of shape {shape}")
        return cls(halves[0], halves[1], spacing, dx, int(bays), max_frequency)


def track_ring(
    track: Track,
    dx: float,
    *,
    bays: int = BAYS,
    max_frequency: float = MAX_FREQUENCY,
    tolerance: float = TOLERANCE,
    progress: Progress | None = None,
) -> TrackRing:
    """Ring of ``bays`` with modes up to ``max_frequency`` (Hz) and tables at steps of ``dx`` (m); kept in the cache.

    ``tolerance`` bounds what modes left out as negligible add to the receptance, as part of its mean over a bay.
    ``progress`` is told what is built and the fraction done. Raises InputError if the spacing is not a whole number
    of steps, or for a ring that is too short.
    """
    steps = round(track.spacing / dx) if dx > 0.0 else 0
    if steps < 1 or abs(steps * dx - track.spacing) > 1e-9 * track.spacing:
        raise InputError(f"dx = {dx:g} m does not divide the sleeper spacing of {track.spacing:g} m: give a whole part")
    if not 10 <= bays <= 1000:
        raise InputError(f"bays = {bays} of the ring is out of range: give 10 to 1000")
    if not 100.0 <= max_frequency <= 2e4:
        raise InputError(f"max_frequency = {max_frequency:g} Hz is out of range: give 100 to 20000 Hz")
    report = progress or (lambda what, fraction: None)

    def build() -> TrackRing:
        halves = []
        for index, half in enumerate(HALVES):

            def part(fraction: float, index: int = index) -> None:
                report("track", (index + fraction) / len(HALVES))

            halves.append(_half_ring(track, half, steps, bays, max_frequency, tolerance, part))
        return TrackRing(halves[0], halves[1], track.spacing, dx, bays, max_frequency)

    sources = [sys.modules[__name__], bay_module, timoshenko, track_module]
    key = cache.digest([track, dx, bays, max_frequency, tolerance], *sources)
    return cache.cached("track", TrackRing, key, build)


def _half_ring(
    track: Track,
    half: Half,
    steps: int,
    bays: int,
    max_frequency: float,
    tolerance: float,
    report: Callable[[float], None],
) -> HalfRing:
    bay = reduce_bay(assemble_bay(track, half, RAIL_ELEMENTS), RAIL_MODES)
    x: Real = np.arange(steps, dtype=np.float64) * (track.spacing / steps)
    shapes = bay.shapes(x)
    limit = 2.0 * np.pi * max_frequency
    plain = assemble_bay(track, half)  # its statics are exact with any number of elements
    plain_shapes = plain.shapes(x)
    static = plain.local(x, x)
    parts = []
    for index in range(bays // 2 + 1):
        kappa = 2.0 * np.pi * index / (bays * track.spacing)
        modes = _bloch_modes(bay, shapes, x, kappa, limit)
        own_mirror = 2 * index in (0, bays)  # kappa and -kappa are the same wave
        static += _compliance(plain, plain_shapes, kappa) * (1.0 if own_mirror else 2.0) / bays
        parts.append(_real_form(modes, own_mirror, bays))
        report((index + 1) / (bays // 2 + 1))
    poles, wavenumbers, inputs, outputs = (np.concatenate([part[i] for part in parts], axis=-1) for i in range(4))
    kept = _kept(poles, inputs, outputs, static, limit, tolerance)
    poles, wavenumbers, inputs, outputs = poles[kept], wavenumbers[kept], inputs[:, kept], outputs[:, kept]
    residual = static + np.sum(inputs * outputs / poles, axis=1).real
    return HalfRing(poles, wavenumbers, np.ascontiguousarray(inputs), np.ascontiguousarray(outputs), residual)


Kept = NDArray[np.bool_]
_Modes = tuple[Complex, Real, Complex, Complex]


def _periodic(bay: Bay, local: Real, phase: complex) -> Complex:
    """Matrix (n, n) of a wave that changes by ``phase`` from one bay to the next."""
    own, ahead = bay.cell(local)
    matrix: Complex = own + ahead * phase + ahead.T / phase
    return matrix


def _compliance(bay: Bay, shapes: tuple[Real, Real], kappa: float) -> Real:
    """Static compliance (nb,) m/N of a wavenumber; its mean over all wavenumbers is that at one point of the ring."""
    phase = np.exp(1j * kappa * bay.track.spacing)
    rows = shapes[0] + shapes[1] * phase
    compliance: Real = np.sum(
        rows.T * np.linalg.solve(_periodic(bay, bay.stiffness, phase), rows.conj().T), axis=0
    ).real
    return compliance


def _bloch_modes(bay: Bay, shapes: tuple[Real, Real], x: Real, kappa: float, limit: float) -> _Modes:
    """Modes with ``|lambda| < limit`` at a wavenumber: poles, wavenumbers (P,), input and output (nb, P).

    Left eigenvectors are the rows of the inverse of the matrix of right ones, which also holds where eigenvalues
    coincide, as they do at both ends of the zone.
    """
    n = bay.size
    phase = np.exp(1j * kappa * bay.track.spacing)
    M, C, K = (_periodic(bay, local, phase) for local in (bay.mass, bay.damping, bay.stiffness))
    scale = np.sqrt(np.linalg.norm(K) / np.linalg.norm(M))  # velocities in the size of deflections
    system = np.block([[np.zeros((n, n)), scale * np.eye(n)], [-np.linalg.solve(M, K) / scale, -np.linalg.solve(M, C)]])
    poles, right = np.linalg.eig(system)
    left = np.linalg.inv(right)
    low = np.abs(poles) < limit
    rows = shapes[0] + shapes[1] * phase
    along = np.exp(1j * kappa * x)[:, None]
    inputs = (left[low, n:] @ np.linalg.solve(M, rows.conj().T)).T / scale * along
    outputs = (rows @ right[:n, low]) / along
    return poles[low], np.full(low.sum(), kappa), inputs, outputs


def _real_form(modes: _Modes, own_mirror: bool, bays: int) -> _Modes:
    """Modes whose real part is the whole response: those of ``-kappa`` are the conjugates of those of ``kappa``."""
    poles, wavenumbers, inputs, outputs = modes
    weight = np.full(poles.size, 2.0 / bays)
    if own_mirror:
        real = np.abs(poles.imag) <= 1e-9 * np.abs(poles)
        weight[real] = 1.0 / bays
        kept = real | (poles.imag > 0.0)
        poles, wavenumbers, weight = poles[kept], wavenumbers[kept], weight[kept]
        inputs, outputs = inputs[:, kept], outputs[:, kept]
    turn = poles.imag < 0.0
    poles = np.where(turn, poles.conj(), poles)
    wavenumbers = np.where(turn, -wavenumbers, wavenumbers)
    return poles, wavenumbers, np.where(turn, inputs.conj(), inputs), np.where(turn, outputs.conj(), outputs) * weight


def _kept(poles: Complex, inputs: Complex, outputs: Complex, static: Real, limit: float, tolerance: float) -> Kept:
    """Modes (P,) that count: those left out together change the receptance by less than ``tolerance``.

    Measured in the lower half of the band, against the root mean square of the direct receptance over the bay. The
    static part of a mode is not lost, so what counts of it is ``i omega / (lambda (i omega - lambda))``.
    """
    omega = np.linspace(0.0, limit / 2.0, 251)[:, None]
    dynamic = omega / (poles * (1j * omega - poles))
    mirrored = omega / (poles.conj() * (1j * omega - poles.conj()))
    sample = slice(None, None, max(1, static.size // 24))
    gain = inputs[sample] * outputs[sample]
    direct = static[sample] + 0.5j * (dynamic @ gain.T + mirrored @ gain.conj().T)
    level = np.sqrt(np.mean(np.abs(direct) ** 2, axis=1))[:, None]
    bound = np.abs(inputs).max(axis=0) * np.abs(outputs).max(axis=0)
    share = bound * (np.abs(dynamic) + np.abs(mirrored)) / 2.0 / level
    order = np.argsort(share.max(axis=0))
    kept = np.empty(poles.size, dtype=bool)
    kept[order] = np.cumsum(share[:, order], axis=1).max(axis=0) > tolerance
    return kept
