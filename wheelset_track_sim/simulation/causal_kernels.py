"""The ``causal`` dynamics step by step: complex modes of wheelset and track, advanced exactly.

Real and imaginary parts stand in arrays of their own, so that the loops run in vector registers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import summing_kernel


class Causal(NamedTuple):
    """State and coefficients; P wheelset modes, Q track modes (the symmetric half's first), L steps a bay.

    The state is the predictor ``r``: each mode at the coming step, but for that step's own force. With the hold
    coefficients ``a, b0, b1`` of ``simulation.hold`` one step is ``r <- a r + (a b1 + b0) s F``, s the modal load of a
    unit force; that product is the gain of a wheel and the input of the track.
    """

    wheel_state: np.ndarray  # (2, P) real and imaginary part of r
    wheel_factor: np.ndarray  # (2, P) a
    wheel_gain: np.ndarray  # (2, 2, P) of wheel m: [part, m]
    wheel_output: np.ndarray  # (2, 2, P) away from the rail, at wheel m: [part, m]
    track_state: np.ndarray  # (2, Q)
    track_factor: np.ndarray  # (2, Q) a in the moving frame
    track_input: np.ndarray  # (2, L, Q) at the position in the bay
    track_output: np.ndarray  # (2, L, Q)
    symmetric: int  # number of modes of the symmetric half
    stress_output: np.ndarray  # (2, S, P) of the S stress components that are not zero by symmetry
    stress_direct: np.ndarray  # (S, 2) Pa/N of the force at the same step
    wheel_compliance: np.ndarray  # (2,) m/N of the force at the same step
    rail_compliance: np.ndarray  # (L,) m/N of the force at the same step
    speed: float  # m/s to which the track modes belong


@summing_kernel
def displacements(dynamics: Causal, step: int, xi: np.ndarray) -> None:
    """Fill ``xi`` (2, 2), m: [0] wheels and [1] rails, at ``step``, without the force of that step itself."""
    re, im = dynamics.wheel_state[0], dynamics.wheel_state[1]
    for wheel in range(2):
        out_re, out_im = dynamics.wheel_output[0, wheel], dynamics.wheel_output[1, wheel]
        total = 0.0
        for p in range(re.size):
            total += out_re[p] * re[p] - out_im[p] * im[p]
        xi[0, wheel] = total
    place = step % dynamics.track_output.shape[1]
    re, im = dynamics.track_state[0], dynamics.track_state[1]
    out_re, out_im = dynamics.track_output[0, place], dynamics.track_output[1, place]
    even = 0.0
    for q in range(dynamics.symmetric):
        even += out_re[q] * re[q] - out_im[q] * im[q]
    odd = 0.0
    for q in range(dynamics.symmetric, re.size):
        odd += out_re[q] * re[q] - out_im[q] * im[q]
    xi[1, 0] = even + odd
    xi[1, 1] = even - odd


@summing_kernel
def advance(dynamics: Causal, step: int, forces: np.ndarray) -> None:
    """Take in the ``forces`` (2,) N of ``step`` and move all modes on to the next one."""
    re, im = dynamics.wheel_state[0], dynamics.wheel_state[1]
    a_re, a_im = dynamics.wheel_factor[0], dynamics.wheel_factor[1]
    g_re, g_im = dynamics.wheel_gain[0], dynamics.wheel_gain[1]
    one, two = forces[0], forces[1]
    for p in range(re.size):
        real = a_re[p] * re[p] - a_im[p] * im[p] + g_re[0, p] * one + g_re[1, p] * two
        im[p] = a_re[p] * im[p] + a_im[p] * re[p] + g_im[0, p] * one + g_im[1, p] * two
        re[p] = real
    place = step % dynamics.track_input.shape[1]
    even, odd = (one + two) / 2, (one - two) / 2
    _advance_track(dynamics, place, 0, dynamics.symmetric, even)
    _advance_track(dynamics, place, dynamics.symmetric, dynamics.track_state.shape[1], odd)


@summing_kernel
def _advance_track(dynamics: Causal, place: int, first: int, last: int, force: float) -> None:
    re, im = dynamics.track_state[0], dynamics.track_state[1]
    a_re, a_im = dynamics.track_factor[0], dynamics.track_factor[1]
    in_re, in_im = dynamics.track_input[0, place], dynamics.track_input[1, place]
    for q in range(first, last):
        real = a_re[q] * re[q] - a_im[q] * im[q] + in_re[q] * force
        im[q] = a_re[q] * im[q] + a_im[q] * re[q] + in_im[q] * force
        re[q] = real


@summing_kernel
def stresses(dynamics: Causal, forces: np.ndarray, stress: np.ndarray) -> None:
    """Fill ``stress`` (S,) Pa at the step whose ``forces`` (2,) N are given; before ``advance``."""
    re, im = dynamics.wheel_state[0], dynamics.wheel_state[1]
    for s in range(stress.size):
        out_re, out_im = dynamics.stress_output[0, s], dynamics.stress_output[1, s]
        total = 0.0
        for p in range(re.size):
            total += out_re[p] * re[p] - out_im[p] * im[p]
        direct = dynamics.stress_direct[s]
        stress[s] = total + direct[0] * forces[0] + direct[1] * forces[1]
