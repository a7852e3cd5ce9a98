"""The track as a ring of bays, seen from a frame that runs along it: Bloch modes, endless running, bounded cost.

A ring of N bays has modes ``u(x) = p(x) exp(i kappa x)`` with ``p`` periodic over one bay and ``kappa`` a multiple of
``2 pi / (N L)``. Each wavenumber is one small eigenproblem of a bay. In a frame fixed to the track a mode with pole
``lambda`` that is loaded by ``F`` at ``X(t)`` obeys, and the deflection at ``x`` is::

    q' = lambda q + s(X) exp(-i kappa X) F,     xi(x) = Re sum_P p(x) exp(i kappa x) q  +  residual,

``s`` periodic over one bay too. With ``r = q exp(i kappa X)`` and ``X = v t + const`` the phases leave the tables::

    r' = (lambda + i kappa v) r + s(X) F,     xi(X) = Re sum_P p(X) r + residual(X) F.

So the tables ``input = s`` and ``output = p`` are indexed by the position in the bay alone (step mod ``nb``), the poles
in the moving frame are ``lambda + i kappa v``, and the step of ``dynamics.hold`` is exact but for ``s(X) F`` taken
linear over one step. Nothing grows with the distance run, and a change of speed changes the poles, not the state.

The halves are driven by ``F_s = (F_1 + F_2) / 2`` and ``F_a = (F_1 - F_2) / 2``; ``xi_1 = xi_s + xi_a`` and
``xi_2 = xi_s - xi_a``.

Modes at ``|lambda| > 2 pi max_frequency`` and modes that hardly count are left out; the static deflection that they
would give is kept in ``residual``, so that statics are exact at every position.

What the defaults cost, as direct receptance of the shipped track against the exact infinite one: 2e-4 to 300 Hz,
1.5 % to 1 kHz, 2.3 % from 1150 Hz to 2 kHz, 4.1 % to 2.5 kHz (modes beyond 5 kHz taken as static), and 23 % at the
tip of the pinned-pinned peak, whose wave outlives its way round 80 bays (5 % with 140). An impact of 2 ms is right to
1e-4 of its 1.1 mm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..runtime.arrays import Complex, Real
from ..runtime.cache import cached
from ..runtime.progress import Progress, unreported
from .bay import assemble_bay, reduce_bay
from .ring_modes import RingModes, bloch_modes, counting, real_form, response_level, static_compliance, thinned
from .track import HALVES, Half, Track

if TYPE_CHECKING:
    from typing_extensions import Self


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


class HalfRingModes(NamedTuple):
    """``r' = poles r + input(X) F``, ``xi = Re(output(X) r)``; the state is ``r`` at any speed."""

    poles: Complex  # (P,) rad/s in the moving frame
    input: Complex  # (nb, P)
    output: Complex  # (nb, P)

    def of_state(self, r: Complex) -> Complex:
        """Modes in a state, which are the state."""
        return r

    def carried(self, other: HalfRingModes, r: Complex) -> Complex:
        """Modes of this speed in the state that is ``r`` in those of the ``other``: the same."""
        return r


@dataclass(frozen=True, eq=False)
class HalfRing:
    """Modes of the ring of a half track in the moving frame; P modes, nb positions a bay."""

    poles: Complex  # (P,) rad/s, Im >= 0: the real part of the sum over them is the whole response
    wavenumbers: Real  # (P,) rad/m
    input: Complex  # (nb, P) s(x) at x = j dx
    output: Complex  # (nb, P) p(x) at x = j dx, in m/N s with the scale of ``input``
    residual: Real  # (nb,) m/N

    def standing(self, position: int, force: float) -> Complex:
        """Modal state (P,) in equilibrium with ``force`` (N) standing at a ``position`` of the bay."""
        state: Complex = -self.input[position] * force / self.poles
        return state

    def compliance(self) -> Real:
        """Static deflection (nb,) for a unit force there, m/N."""
        static: Real = self.residual - (self.output * self.input / self.poles).real.sum(axis=1)
        return static

    def modes(self, speed: float) -> HalfRingModes:
        """The same modes in a frame that runs at ``speed`` (m/s): all decay as they do at rest."""
        return HalfRingModes(self.moving_poles(speed), self.input, self.output)

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
    if not 0.0 <= tolerance <= 0.2:
        raise InputError(f"tolerance = {tolerance:g} of the ring is out of range: give 0 to 0.2")
    return cached("track", TrackRing, _ring, track, dx, bays, max_frequency, tolerance, progress=progress)


def _ring(
    track: Track, dx: float, bays: int, max_frequency: float, tolerance: float, progress: Progress | None
) -> TrackRing:
    report = progress or unreported
    steps, halves = round(track.spacing / dx), []
    for index, half in enumerate(HALVES):

        def part(fraction: float, index: int = index) -> None:
            report("track", (index + fraction) / len(HALVES))

        halves.append(_half_ring(track, half, steps, bays, max_frequency, tolerance, part))
    return TrackRing(halves[0], halves[1], track.spacing, dx, bays, max_frequency)


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
        own_mirror = 2 * index in (0, bays)  # kappa and -kappa are the same wave
        static += static_compliance(plain, plain_shapes, kappa) * (1.0 if own_mirror else 2.0) / bays
        parts.append(real_form(bloch_modes(bay, shapes, x, kappa, limit), own_mirror, bays))
        report((index + 1) / (bays // 2 + 1))
    modes = RingModes(*(np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True)))
    omega: Real = np.linspace(0.0, limit / 2.0, 251)
    level = response_level(modes, static, omega)
    modes = thinned(modes, bays, track.spacing, omega, level, tolerance)
    modes = modes.at(counting(modes, omega, level, tolerance))
    residual = static + np.sum(modes.input * modes.output / modes.poles, axis=1).real
    return HalfRing(
        modes.poles,
        modes.wavenumbers,
        np.ascontiguousarray(modes.input),
        np.ascontiguousarray(modes.output),
        residual,
    )
