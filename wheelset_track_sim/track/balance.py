"""The ring of bays reduced to the states that a running wheel can excite and feel.

Most modes of the ring are far from the wheel, or cancel each other where it is. Balanced truncation (B. C. Moore,
"Principal component analysis in linear systems", IEEE Transactions on Automatic Control 26 (1981) 17-32) keeps the
directions in which the reachability Gramian ``P`` and the observability Gramian ``Q`` are both large. In the moving
frame the modes obey ``r' = (lambda + i kappa v) r + s(X) F`` with ``s`` periodic in the position; for the mean over
the positions of a bay both Gramians have closed forms::

    <r r^H>_kl = -mean(s_k conj(s_l)) / (m_k + conj(m_l)),      m = lambda + i kappa v.

They are added up over the speeds that a train runs at, so that one real projection ``x = T z``, ``W^T T = 1`` serves
them all: the state ``z`` means the same at every speed, and only ``A_0 + v A_1`` changes with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from ..runtime.arrays import Complex, Real
from ..runtime.cache import cached
from ..runtime.progress import Progress, unreported
from .ring import MAX_FREQUENCY, HalfRing, track_ring
from .track import Track

if TYPE_CHECKING:
    from typing_extensions import Self


ORDER = 200
"""Real states of a half track."""

ROUNDING = 1e-12
"""Share of the largest Hankel singular value below which a state is made of rounding errors."""

SPEEDS = (7.0, 15.0, 30.0, 60.0, 100.0)
"""Speeds, m/s, whose Gramians are added."""


@dataclass(frozen=True, eq=False)
class HalfTrack:
    """Half a track in n real states ``z`` that the moving frame carries along; L positions a bay.

    ``z' = (A_0 + v A_1) z + input(X) F``, ``xi = output(X) z + residual(X) F``.
    """

    rate: Real  # (n, n) A_0, 1/s
    rate_of_speed: Real  # (n, n) A_1, 1/m
    input: Real  # (L, n)
    output: Real  # (L, n)
    residual: Real  # (L,) m/N

    def standing(self, position: int, force: float) -> Real:
        """State (n,) in equilibrium with ``force`` (N) standing at a ``position`` of the bay."""
        state: Real = -np.linalg.solve(self.rate, self.input[position]) * force
        return state

    def compliance(self) -> Real:
        """Static deflection (L,) for a unit force there, m/N."""
        static = -(self.output * np.linalg.solve(self.rate, self.input.T).T).sum(axis=1)
        return np.asarray(static + self.residual)

    def modes(self, speed: float) -> HalfModes:
        """The same half track in modes of the moving frame at ``speed`` (m/s)."""
        poles, shapes = np.linalg.eig(self.rate + speed * self.rate_of_speed)
        kept = poles.imag >= 0.0  # of a conjugate pair one, with twice the output
        poles, shapes = poles[kept].astype(np.complex128), shapes[:, kept]
        shapes = np.where(poles.imag > 0.0, 2.0, 1.0) * shapes
        to_state = np.concatenate([shapes.real, -shapes.imag[:, poles.imag > 0.0]], axis=1)
        return HalfModes.of(poles, to_state, self.input, self.output)


@dataclass(frozen=True, eq=False)
class HalfModes:
    """``r' = poles r + input(X) F``, ``xi = Re(output(X) r)``.

    Both ways between modes and states are products of real matrices, a quarter of the work of complex ones: they take
    and give the real parts of all modes, and the imaginary parts of those whose pole has one.
    """

    poles: Complex  # (P,) rad/s in the moving frame
    input: Complex  # (L, P)
    output: Complex  # (L, P)
    to_state: Real  # (n, n)
    from_state: Real  # (n, n)

    @classmethod
    def of(cls, poles: Complex, to_state: Real, inputs: Real, outputs: Real) -> HalfModes:
        """Modes from their poles and ``to_state``, with inputs and outputs (L, n) of the state."""
        from_state: Real = np.asarray(np.linalg.inv(to_state), dtype=np.float64)
        return cls(
            poles=poles,
            input=_modes(inputs @ from_state.T, poles),
            output=_modes(outputs @ to_state, poles).conj(),
            to_state=to_state,
            from_state=from_state,
        )

    def of_state(self, z: Real) -> Complex:
        """Modes (..., P) in a state ``z`` (..., n)."""
        return _modes(z @ self.from_state.T, self.poles)

    def in_state(self, r: Complex) -> Real:
        """State (..., n) in which the modes are ``r`` (..., P)."""
        parts = np.concatenate([r.real, r.imag[..., self.poles.imag > 0.0]], axis=-1)
        return np.asarray(parts @ self.to_state.T)

    def carried(self, other: HalfModes, r: Complex) -> Complex:
        """Modes (..., P) of this speed in the state that is ``r`` (..., P) in those of the ``other``."""
        return self.of_state(other.in_state(r))


@dataclass(frozen=True, eq=False)
class MovingTrack:
    """Both halves of a track, driven by ``(F_1 + F_2) / 2`` and ``(F_1 - F_2) / 2``, as in ``track_ring``."""

    symmetric: HalfTrack
    antisymmetric: HalfTrack

    @property
    def halves(self) -> tuple[HalfTrack, HalfTrack]:
        """Symmetric and antisymmetric half."""
        return self.symmetric, self.antisymmetric

    def without_residual(self) -> MovingTrack:
        """The same track without what its left-out modes deflect at once."""
        return MovingTrack(*(replace(half, residual=np.zeros_like(half.residual)) for half in self.halves))

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name."""
        halves = {"symmetric": self.symmetric, "antisymmetric": self.antisymmetric}
        return {f"{name}_{f.name}": getattr(half, f.name) for name, half in halves.items() for f in fields(HalfTrack)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Track from its arrays; raises KeyError or ValueError."""
        halves = [
            HalfTrack(**{f.name: arrays[f"{name}_{f.name}"] for f in fields(HalfTrack)})
            for name in ("symmetric", "antisymmetric")
        ]
        for half in halves:
            if half.input.shape != half.output.shape or half.rate.shape != half.rate_of_speed.shape:
                raise ValueError("these are no reduced tracks")
        return cls(*halves)


def moving_track(
    track: Track,
    dx: float,
    *,
    max_frequency: float = MAX_FREQUENCY,
    order: int = ORDER,
    progress: Progress | None = None,
) -> MovingTrack:
    """Ring of a track (``track_ring``) reduced to ``order`` real states a half; kept in the cache."""
    return cached("moving-track", MovingTrack, _reduced, track, dx, max_frequency, order, progress=progress)


def _reduced(track: Track, dx: float, max_frequency: float, order: int, progress: Progress | None) -> MovingTrack:
    report = progress or unreported
    ring = track_ring(track, dx, max_frequency=max_frequency, progress=progress)
    symmetric = balanced(ring.symmetric, order)
    report("track reduction", 0.5)
    antisymmetric = balanced(ring.antisymmetric, order)
    report("track reduction", 1.0)
    return MovingTrack(symmetric, antisymmetric)


def balanced(half: HalfRing, order: int) -> HalfTrack:
    """Half a ring in its ``order`` real states that count most; in fewer if the others are lost in rounding."""
    modes = len(half.poles)
    reach = observe = np.zeros((2 * modes, 2 * modes))
    for speed in SPEEDS:
        poles = half.moving_poles(speed)
        reach = reach + gramian(poles, half.input)
        observe = observe + gramian(poles.conj(), half.output.conj())
    reached, observed = _root(reach), _root(observe)
    left, values, right = np.linalg.svd(observed.T @ reached)
    order = min(order, int(np.count_nonzero(values > ROUNDING * values[0])))
    scale = 1.0 / np.sqrt(values[:order])
    T = reached @ right[:order].T * scale  # (2 modes, order)
    W = observed @ left[:, :order] * scale
    return HalfTrack(
        rate=W.T @ _times(half.poles, T),
        rate_of_speed=W.T @ _times(np.asarray(1j * half.wavenumbers), T),
        input=np.concatenate([half.input.real, half.input.imag], axis=1) @ W,
        output=np.concatenate([half.output.real, -half.output.imag], axis=1) @ T,
        residual=half.residual,
    )


def gramian(poles: Complex, inputs: Complex) -> Real:
    """Reachability Gramian (2P, 2P) of ``[Re r, Im r]`` for modes (P,), mean over the positions of inputs (L, P)."""
    conjugate = -(inputs.T @ inputs.conj()) / len(inputs) / np.add.outer(poles, poles.conj())
    plain = -(inputs.T @ inputs) / len(inputs) / np.add.outer(poles, poles)
    real, imaginary = (conjugate + plain).real, (conjugate - plain).real
    mixed = (plain - conjugate).imag
    return np.block([[real, mixed], [mixed.T, imaginary]]) / 2.0


def _modes(parts: Real, poles: Complex) -> Complex:
    """Modes (..., P) from the real parts of all and the imaginary parts of those whose pole has one, (..., n)."""
    modes = parts[..., : len(poles)].astype(np.complex128)
    modes.imag[..., poles.imag > 0.0] = parts[..., len(poles) :]
    return modes


def _root(gram: Real) -> Real:
    """A factor ``L`` with ``L L^T`` the Gramian, which is positive but for rounding."""
    values, vectors = np.linalg.eigh(gram)
    root: Real = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _times(factors: Complex, T: Real) -> Real:
    """``[Re r, Im r]`` of modes multiplied by complex ``factors`` (P,), column by column of ``T`` (2P, n)."""
    re, im = np.split(T, 2)
    a, b = factors.real[:, np.newaxis], factors.imag[:, np.newaxis]
    return np.concatenate([a * re - b * im, b * re + a * im])
