"""The ring of bays reduced to the states that matter to a running wheel: balanced truncation.

Problem. Half a ring (``track.ring``) has P modes. Most of them hardly move where the wheel is. Find n << 2 P real
states with nearly the same response in the frame that moves with the wheel, at any speed v::

    r' = diag(m) r + s(X) F,    xi = Re(p(X).r) + residual(X) F,    m = lambda + i kappa v

    r       modes, (P,)                lambda, kappa   ``poles``, rad/s, and ``wavenumbers``, rad/m, of the ring
    F       N, force on the half       s, p            ``input`` and ``output``, (L, P), at L positions X of a bay
    xi      m, deflection under it     v               m/s

Real form. With x = [Re r, Im r] the system is x' = (A_0 + v A_1) x + b(X) F, xi = c(X).x. A_0 multiplies modes by
lambda, A_1 by i kappa; b = [Re s, Im s], and c = [Re p, -Im p].

Gramians. b and c vary with the position, which runs through a bay again and again. The mean over starting positions of
the energy of impulse responses obeys a Lyapunov equation with the means of b b^T and c^T c, which is solved mode by
mode (``gramian``)::

    <r r^H>_kl = int_0^inf mean(s_k e^(m_k t) conj(s_l e^(m_l t))) dt = -mean(s_k conj(s_l)) / (m_k + conj(m_l))
    <r r^T>_kl = -mean(s_k s_l) / (m_k + m_l)

    reach    G_r = <x x^T>, with     <Re Re> = Re(<r r^H> + <r r^T>) / 2,   <Im Im> = Re(<r r^H> - <r r^T>) / 2,
                                     <Re Im> = Im(<r r^T> - <r r^H>) / 2
    observe  G_o: the same with conj(m) for m and conj(p) for s, which is the system with A^T and c^T

Both are summed over SPEEDS, so that one projection serves all speeds.

Projection. With G_r = R R^T, G_o = O O^T and the singular values O^T R = U diag(sigma) V^T::

    T = R V_n diag(sigma_n)^-1/2,    W = O U_n diag(sigma_n)^-1/2,    W^T T = 1
    z' = W^T (A_0 + v A_1) T z + W^T b(X) F,    xi = c(X).T z + residual(X) F

Both Gramians of z are diag(sigma_n): states that are hard to reach or hard to observe are left out. T and W are the
same for all v, so a state z keeps its meaning when the speed changes.

Accuracy. Moore's and Glover's theorems hold for one system with its own Gramians, not for their sum over speeds: there
is no bound, and no proof that z decays. With the shipped ``ballasted_60e1`` and n = 200 of 2 P = 1024, impulse
responses from 5 to 120 m/s err by 3e-4 of their largest value, statics by 2e-4 (``tests/track/test_balance.py``).
All poles of the shipped tracks decay from 1 to 120 m/s.

Where it fails. The ring itself is stable at every speed, for Re m = Re lambda < 0. Stiff or little damped pads leave
many modes that hardly decay, and n states are too few for them: with ten times the stiffness and a fifth of the damping
an impulse response errs by 4 %, with a hundredth of the damping by 30 %, and some poles of the reduction grow, by up to
9 1/s. Growing poles are no property of the track. So a reduction is checked when it is made (``serves``): if a pole
grows at one of CHECKED, or impulse responses err by more than ERROR, the half track keeps all modes of its ring, which
takes some five times the arithmetic a step.

Cost: Gramians and their decomposition take some (2 P)^3 operations, once; the states are kept in the cache.

Sources: B. C. Moore, IEEE Trans. Automatic Control 26 (1981) 17-32, for balanced truncation; M. S. Tombs and I.
Postlethwaite, Int. J. Control 46 (1987) 1319-1330, for the projection from square roots. The Gramians of the moving
load are derived here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..errors import DivergenceError
from ..runtime.arrays import Complex, Real
from ..runtime.cache import cached
from ..runtime.progress import Progress, unreported
from .ring import MAX_FREQUENCY, HalfRing, track_ring
from .track import HALVES, Track

if TYPE_CHECKING:
    from typing_extensions import Self


ORDER = 200
"""Real states of a half track."""

ROUNDING = 1e-12
"""Share of the largest Hankel singular value below which a state is made of rounding errors."""

SPEEDS = (7.0, 15.0, 30.0, 60.0, 100.0)
"""Speeds, m/s, whose Gramians are summed."""

CHECKED = tuple(np.arange(5.0, 100.1, 5.0))
"""Speeds, m/s, over the range of scenarios, at which the poles of a reduction have to decay."""

ERROR = 0.01
"""Of an impulse response, as a share of its largest value, above which a reduction is not used."""


@dataclass(frozen=True, eq=False)
class HalfTrack:
    """Half a track in n real states ``z`` of the moving frame; L positions a bay.

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
        """The same half track in modes of the moving frame at ``speed`` (m/s).

        With the eigenvectors E_k of A_0 + v A_1, z = sum_k E_k r_k. A conjugate pair adds 2 Re(E_k r_k), so one of each
        pair is kept, with the factor 2 in E_k.
        """
        poles, shapes = np.linalg.eig(self.rate + speed * self.rate_of_speed)
        if poles.real.max() >= 0.0:
            raise DivergenceError(
                f"the reduced track is unstable (growth {poles.real.max():.3g} 1/s) at speed = {speed:g} m/s: give "
                "another speed, or pads that are softer or more damped"
            )
        kept = poles.imag >= 0.0  # of a conjugate pair one, with twice the output
        poles, shapes = poles[kept].astype(np.complex128), shapes[:, kept]
        shapes = np.where(poles.imag > 0.0, 2.0, 1.0) * shapes
        to_state = np.concatenate([shapes.real, -shapes.imag[:, poles.imag > 0.0]], axis=1)
        return HalfModes.of(poles, to_state, self.input, self.output)


@dataclass(frozen=True, eq=False)
class HalfModes:
    """``r' = poles r + input(X) F``, ``xi = Re(output(X) r)``.

    ``to_state`` and ``from_state`` are real: their products take a quarter of the work of complex ones. They act on the
    real parts of all modes, then the imaginary parts of those whose pole has one.
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


class MovingModes(Protocol):
    """Modes of a half track at one speed, reduced (``HalfModes``) or not (``HalfRingModes``)."""

    @property
    def poles(self) -> Complex:
        """(P,) rad/s in the moving frame."""
        ...

    @property
    def input(self) -> Complex:
        """(L, P)."""
        ...

    @property
    def output(self) -> Complex:
        """(L, P)."""
        ...

    def of_state(self, state: Any, /) -> Complex:
        """Modes (..., P) in a state of the half track, which means the same at all speeds."""
        ...

    def carried(self, other: Any, r: Complex) -> Complex:
        """Modes (..., P) of this speed in the state that is ``r`` (..., P) in those of the ``other``."""
        ...


@dataclass(frozen=True, eq=False)
class MovingTrack:
    """Both halves of a track, driven by ``(F_1 + F_2) / 2`` and ``(F_1 - F_2) / 2``, as in ``track_ring``.

    A half is reduced, or has all modes of its ring where the reduction would not serve.
    """

    symmetric: HalfTrack | HalfRing
    antisymmetric: HalfTrack | HalfRing

    @property
    def halves(self) -> tuple[HalfTrack | HalfRing, HalfTrack | HalfRing]:
        """Symmetric and antisymmetric half."""
        return self.symmetric, self.antisymmetric

    def without_residual(self) -> MovingTrack:
        """The same track without what its left-out modes deflect at once."""
        return MovingTrack(*(replace(half, residual=np.zeros_like(half.residual)) for half in self.halves))

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name."""
        halves = zip(HALVES, self.halves, strict=True)
        return {f"{name}_{f.name}": getattr(half, f.name) for name, half in halves for f in fields(half)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Track from its arrays; raises KeyError or ValueError."""
        halves = []
        for name in HALVES:
            kind = HalfRing if f"{name}_poles" in arrays else HalfTrack
            halves.append(kind(**{f.name: arrays[f"{name}_{f.name}"] for f in fields(kind)}))
        for half in halves:
            if half.input.shape != half.output.shape or len(half.residual) != len(half.input):
                raise ValueError("these are no tracks in a moving frame")
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
    halves: list[HalfTrack | HalfRing] = []
    for half in (ring.symmetric, ring.antisymmetric):
        reduced = balanced(half, order)
        halves.append(reduced if serves(reduced, half, dx) else half)
        report("track reduction", len(halves) / 2)
    return MovingTrack(*halves)


def serves(reduced: HalfTrack, half: HalfRing, dx: float) -> bool:
    """Whether a reduction decays at all speeds CHECKED, and answers an impulse as its ring does, within ERROR."""
    if any(np.linalg.eigvals(reduced.rate + v * reduced.rate_of_speed).real.max() >= 0.0 for v in CHECKED):
        return False
    right, found = (impulse_response(each.modes(SPEEDS[2]), dx / SPEEDS[2]) for each in (half, reduced))
    return bool(np.abs(found - right).max() <= ERROR * np.abs(right).max())


def impulse_response(modes: MovingModes, dt: float) -> Real:
    """Deflection (3 L,), m/(N s), under the wheel in the steps of ``dt`` s after an impulse in the middle of a bay."""
    places = len(modes.input)
    state, factor = modes.input[places // 2], np.exp(modes.poles * dt)
    deflection = np.empty(3 * places)
    for step in range(len(deflection)):
        deflection[step] = (modes.output[(places // 2 + step) % places] @ state).real
        state = state * factor
    return deflection


def balanced(half: HalfRing, order: int) -> HalfTrack:
    """Reduce half a ring to n real states, as derived above.

    Parameters
    ----------
    half
        P modes of half a ring.
    order
        n; fewer states are kept where the singular values of the others are rounding errors (``ROUNDING``).

    Returns
    -------
    reduced
        n states. The residual of the ring is taken over, so statics err as much as the dynamics.
    """
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
    """Reachability Gramian of [Re r, Im r], mean over the positions of the load.

    Parameters
    ----------
    poles
        m, (P,), rad/s, all with a negative real part.
    inputs
        s, (L, P).

    Returns
    -------
    gramian
        (2 P, 2 P); symmetric, and positive but for rounding.
    """
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
    """A factor R of the Gramian R R^T; negative eigenvalues, which are rounding errors, count as zero."""
    values, vectors = np.linalg.eigh(gram)
    root: Real = vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _times(factors: Complex, T: Real) -> Real:
    """Multiply modes by complex ``factors`` (P,), column by column of ``T`` (2 P, n), whose rows are [Re r, Im r]."""
    re, im = np.split(T, 2)
    a, b = factors.real[:, np.newaxis], factors.imag[:, np.newaxis]
    return np.concatenate([a * re - b * im, b * re + a * im])
