"""First-order hold: the exact step of complex modes under a modal load that is linear between samples.

A mode ``q' = lambda q + g(t)`` with ``g`` linear from ``g[n]`` to ``g[n+1]`` over the step ``dt`` is solved by::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1],    a = exp(z),   z = lambda dt,
    b1 = dt phi_2(z),   b0 = dt (phi_1(z) - phi_2(z)),
    phi_1(z) = (e^z - 1) / z,   phi_2(z) = (e^z - 1 - z) / z^2.

For ``z -> 0`` both weights tend to ``dt / 2``, the trapezoidal rule.

That is exact for the mode, but the contact sees it once a step only. A mode near half the sampling rate or above
answers through an alias, which can feed the contact force with the wrong sign: such modes exist below 12 m/s with steps
of 1 mm, and at 6, 9.75 and 10 m/s they made the force of a smooth wheel grow without bound. They follow their load at
once instead, ``q = -g / lambda``. In between, the share ``w`` of the load is stepped and the rest is followed at once,
so that nothing jumps where a changing speed passes a mode::

    q = p - (1 - w) g / lambda,   p' = lambda p + w g,
    b0 <- w b0 + (1 - w) a / lambda,   b1 <- w b1 - (1 - w) / lambda.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import Complex

RESOLVED, ALIASED = 0.9, 1.0
"""Shares of half the sampling rate up to which modes are stepped, and from which on they follow their load at once.
With both 1.0 the force still grows at some speeds; so it does at none of 220 from 5 to 16 m/s. Lower ones are less
accurate: the impact of `damage_wheel_1` at 40 km/h differs by 1.6 kN at most from that with steps of half the length,
with 0.8 for both by 3.0 kN."""

_SERIES_BELOW = 0.5
_TERMS = 14  # 0.5**14 / 16! is far below the rounding of phi_2(0) = 1/2


class Hold(NamedTuple):
    """One step of modes: ``q[n+1] = factor q[n] + before g[n] + after g[n+1]``, each of the shape of the poles."""

    factor: Complex
    before: Complex
    after: Complex


def hold(poles: Complex, dt: float) -> Hold:
    """Step of ``dt`` s of modes with ``poles`` in rad/s; those that it does not resolve follow their load at once."""
    before, after = hold_coefficients(poles, dt)
    factor = np.exp(poles * dt)
    within = np.clip((ALIASED - np.abs(poles.imag) * dt / math.pi) / (ALIASED - RESOLVED), 0.0, 1.0)
    stepped = within**2 * (3.0 - 2.0 * within)
    at_once = (1.0 - stepped) / np.where(stepped < 1.0, poles, 1.0)
    return Hold(
        np.where(stepped > 0.0, factor, 0.0),
        np.where(stepped > 0.0, stepped * before + factor * at_once, 0.0),
        stepped * after - at_once,
    )


def hold_coefficients(poles: Complex, dt: float) -> tuple[Complex, Complex]:
    """Weights ``(b0, b1)`` in s, each of the shape of ``poles`` (rad/s), of the load at both ends of a step ``dt`` (s).

    Where ``|lambda dt| < 0.5`` the closed form of ``phi_2`` loses digits and its Taylor series is summed instead.
    """
    z: Complex = np.asarray(poles, dtype=np.complex128) * dt
    small = np.abs(z) < _SERIES_BELOW
    safe = np.where(small, 1.0, z)
    closed = (np.expm1(safe) - safe) / safe**2
    phi_2: Complex = np.where(small, _phi_2_series(np.where(small, z, 0.0)), closed)
    before: Complex = dt * (1.0 + z * phi_2 - phi_2)  # phi_1 = 1 + z phi_2
    after: Complex = dt * phi_2
    return before, after


def _phi_2_series(z: Complex) -> Complex:
    total = np.zeros_like(z)
    for order in reversed(range(_TERMS)):
        total = total * z + 1.0 / math.factorial(order + 2)
    return total
