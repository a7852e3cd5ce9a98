"""The ``paper`` dynamics step by step: convolution with Green's functions, Eqs (4) to (7) and (16), as printed.

With Green's functions integrated over a step (Eqs (3) and (15)), G~[n] in m/N, the displacements at step alpha are::

    wheels   xi_m[alpha] = sum_j sum_n>=1 G~_mj[n] F_j[alpha - n]                                  Eqs (4), (5)
    rails    xi_m[alpha] = sum_j sum_n>=1 G~_mj,X(alpha - n)[n] F_j[alpha - n] + G~_X(alpha)[0] F_m[alpha]
                                                                                                   Eqs (6), (7)
    stress   sigma[alpha] = sum_j sum_n>=1 S~_j[n] F_j[alpha - n]                                  Eq. (16)

Here n counts from 0, in the paper from 1. G~_X are the moving Green's functions of a load that hit the rail at the
place X of the bay. The wheel's first value is zero (Section 2.3); the rail's acts on its own rail only, as a
compliance.

Static load. Before the run the force has been P for ever. The sums run over F - P of the run, and what P displaces is
added: a constant at the wheels, and a periodic function of the place in the bay on the rails.

Order of the sums. At the wheels G~ is the same at all steps, so each step sums over the past: N multiply-adds. On the
rails G~ depends on the place of the load, so each force is added to the displacements of the M coming steps instead, in
a ring buffer: the same sum in another order, and each table row is read once.

Accuracy: as printed. The rule in time is the trapezoidal one, and receptances are limited in frequency. Cost: 4 N + 4 M
multiply-adds a step, and 2 N for each stress component. A run is limited to N steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.jit import summing_kernel


class Paper(NamedTuple):
    """Time-integrated Green's functions and past forces; L steps a bay, N and M samples, S stress components."""

    wheel: np.ndarray  # (2, 2, N) m/N of Eqs (4) and (5): [response, force]; the first value is zero
    direct: np.ndarray  # (L, M) m/N of Eqs (6) and (7) on the loaded rail, by the place where the load hits
    cross: np.ndarray  # (L, M) on the opposite rail
    stress: np.ndarray  # (S, 2, N) Pa/N of Eq. (15)
    wheel_static: np.ndarray  # (2,) m that the static load displaces the wheels
    rail_static: np.ndarray  # (L,) m that it displaces the rails while it runs over them
    stress_static: np.ndarray  # (S,) Pa
    load: float  # P, N on each wheel
    past: np.ndarray  # (2, N) F - P of the steps done, the newest first, from index N - done[0] on
    coming: np.ndarray  # (2, M) m on the rails at coming steps by F - P of the steps done; step modulo M
    done: np.ndarray  # (1,) number of steps done
    wheel_compliance: np.ndarray  # (2,) m/N of the force at the same step: zero
    rail_compliance: np.ndarray  # (L,) m/N of the force at the same step


@summing_kernel
def displacements(dynamics: Paper, step: int, xi: np.ndarray) -> None:
    """Fill ``xi`` (2, 2), m: [0] wheels and [1] rails, at ``step``, without the force of that step itself."""
    place = step % dynamics.rail_static.size
    slot = step % dynamics.coming.shape[1]
    for wheel in range(2):
        total = 0.0
        for other in range(2):
            total += _convolution(dynamics.wheel[wheel, other], dynamics.past[other], dynamics.done[0])
        xi[0, wheel] = dynamics.wheel_static[wheel] + total
        xi[1, wheel] = dynamics.rail_static[place] + dynamics.coming[wheel, slot]


@summing_kernel
def advance(dynamics: Paper, step: int, forces: np.ndarray) -> None:
    """Apply the ``forces``, (2,), N, of ``step``: to the past, and to the coming displacements of the rails."""
    place = step % dynamics.rail_static.size
    samples = dynamics.coming.shape[1]
    slot = step % samples
    for rail in range(2):
        one = forces[rail] - dynamics.load
        other = forces[1 - rail] - dynamics.load
        coming, direct, cross = dynamics.coming[rail], dynamics.direct[place], dynamics.cross[place]
        coming[slot] = 0.0
        for n in range(1, samples - slot):
            coming[slot + n] += direct[n] * one + cross[n] * other
        for n in range(max(1, samples - slot), samples):
            coming[slot + n - samples] += direct[n] * one + cross[n] * other
    newest = dynamics.past.shape[1] - dynamics.done[0] - 1
    for wheel in range(2):
        dynamics.past[wheel, newest] = forces[wheel] - dynamics.load
    dynamics.done[0] += 1


@summing_kernel
def stresses(dynamics: Paper, forces: np.ndarray, stress: np.ndarray) -> None:
    """Fill ``stress`` (S,) Pa by Eq. (16), whose sum starts at the force of the step before."""
    for s in range(stress.size):
        total = 0.0
        for wheel in range(2):
            total += _convolution(dynamics.stress[s, wheel], dynamics.past[wheel], dynamics.done[0])
        stress[s] = dynamics.stress_static[s] + total


@summing_kernel
def sensed(dynamics: Paper, forces: np.ndarray, signals: np.ndarray) -> None:
    """Fill nothing: sensors read the state of modes, which these dynamics do not have."""


@summing_kernel
def _convolution(green: np.ndarray, past: np.ndarray, count: int) -> float:
    """Sum over n = 1 to ``count`` of green[n] times the force n steps ago; ``past`` has the newest first."""
    before = past.size - count - 1
    total = 0.0
    for n in range(1, min(count, green.size - 1) + 1):
        total += green[n] * past[before + n]
    return total
