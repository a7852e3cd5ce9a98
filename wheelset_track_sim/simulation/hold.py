"""First-order hold: the exact step of complex modes under a modal load that is linear between samples.

A mode ``q' = lambda q + g(t)`` with ``g`` linear from ``g[n]`` to ``g[n+1]`` over the step ``dt`` is solved by::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1],    a = exp(z),   z = lambda dt,
    b1 = dt phi_2(z),   b0 = dt (phi_1(z) - phi_2(z)),
    phi_1(z) = (e^z - 1) / z,   phi_2(z) = (e^z - 1 - z) / z^2.

For ``z -> 0`` both weights tend to ``dt / 2``, the trapezoidal rule.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

_SERIES_BELOW = 0.5
_TERMS = 14  # 0.5**14 / 16! is far below the rounding of phi_2(0) = 1/2


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
