"""The ``paper`` dynamics step by step: convolution with Green's functions, Eqs (4) to (7) and (16), as printed.

The forces before the run are the static load ``P``, for ever. So the convolutions run over ``F - P``, and what the
constant ``P`` displaces is added: a constant at the wheels, and on the rail a function of the place in the bay.
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
    """Take in the ``forces`` (2,) N of ``step``: into the past, and into what is to come on the rails."""
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
def _convolution(green: np.ndarray, past: np.ndarray, count: int) -> float:
    """Sum over n of green[n] times the force n steps ago, n = 1 to ``count``."""
    before = past.size - count - 1
    total = 0.0
    for n in range(1, min(count, green.size - 1) + 1):
        total += green[n] * past[before + n]
    return total
