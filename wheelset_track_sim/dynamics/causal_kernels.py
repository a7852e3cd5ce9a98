"""The ``causal`` dynamics step by step: Eqs (4) to (7) and (14) as modes in state space, advanced exactly.

Problem. Convolve the forces with Green's functions, xi(t) = int F(tau) G(t - tau) dtau. Here each of them is a sum over
complex modes, G(t) = Re sum_k c_k s_k exp(lambda_k t), so the convolution is a set of first-order equations::

    q_k' = lambda_k q_k + s_k F(t),    xi = Re sum_k c_k q_k + r F

    lambda  rad/s             poles of the wheelset, or of half the track in the moving frame (``track.balance``)
    s, c    q/(N s), m/q      input and output of a mode; on the track both depend on the position X in the bay
    r       m/N               static residual of the modes left out

Step. Let F be linear between steps (``hold``), g = s F, and a = exp(lambda dt). Then, with weights b0 and b1 in s::

    q[n+1] = a q[n] + b0 g[n] + b1 g[n+1].

All but the last term is known before the force of the step. That part r[n] = q[n] - b1 g[n], the predictor, is stored::

    r[n+1] = a r[n] + (a b1 + b0) s[n] F[n]                               ``advance``; the gain is (a b1 + b0) s
    xi[n]  = Re sum c[n] r[n] + c0 F[n],   c0 = Re sum c b1 s + r         ``coming`` and ``*_compliance``

On the track s[n] and c[n] belong to the place in the bay at step n. The contact is solved with the compliance c0, so
contact and structure need no iteration. Both rails are the halves of a symmetric track under (F_1 + F_2) / 2 and
(F_1 - F_2) / 2: xi_1 is the sum of both halves, xi_2 their difference.

Accuracy. The step is exact for forces that are linear within a step, at any dt, but for modes near and above half the
sampling rate (``hold``). Each mode decays by |a| < 1 a step. Left out is what a force displaces the other contact at
once: with the shipped models 3e-5 of what it displaces its own wheel, and 0.7 % of its own rail (6e-13 m/N).

Cost: 12 multiply-adds a mode of the wheelset, 8 a mode of half the track, 2 a mode and stress component.

Memory. Modes are stored in banks: real and imaginary parts of the rows of a bank are ``ROW`` numbers apart in one
array, whatever the number of modes. With distances that the compiler knows it need not test in every step whether the
arrays that a loop reads and writes overlap, which took longer than the arithmetic. More than ``ROW`` modes fill several
banks.

Source: state-space form of the modal sum; the predictor is derived here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..runtime.jit import summing_kernel

ROW = 136
"""Modes in a bank: room for the shipped models in one; no power of two, whose rows would contend for cache lines."""


class Causal(NamedTuple):
    """State and coefficients; P wheelset modes, Q modes of each half of the track, L steps a bay.

    The state is the predictor r of each mode. The halves of the track are the symmetric and the antisymmetric one.
    Numbers of modes are rounded up to whole vector registers.
    """

    wheels: np.ndarray  # (banks, 12 ROW) rows r, a, gain of wheel 1 and 2, output of wheel 1 and 2 away from the rail
    wheel_modes: int  # P
    track: np.ndarray  # (2 halves, banks, 4 ROW) rows r, a; a in the moving frame
    places: np.ndarray  # (L, 2 halves, banks, 4 ROW) rows input at the place in the bay, output at the next place
    track_modes: int  # Q
    coming: np.ndarray  # (2, 2) m displacements of wheels and rails at the coming step, without its own force
    stress_output: np.ndarray  # (groups, banks, 8 ROW) rows of four stress components, of the first R modes
    stress_modes: int  # R <= P
    stress_direct: np.ndarray  # (S <= 4 groups, 2) Pa/N of the force at the same step
    sensor_output: np.ndarray  # (pairs, banks, 4 ROW) two rows of sensors each, of the first T modes
    sensor_modes: int  # T <= P
    sensor_direct: np.ndarray  # (rows <= 2 pairs, 2) of the force at the same step
    wheel_compliance: np.ndarray  # (2,) m/N of the force at the same step
    rail_compliance: np.ndarray  # (L,) m/N of the force at the same step
    speed: float  # m/s to which the track modes belong


@summing_kernel
def displacements(dynamics: Any, step: int, xi: np.ndarray) -> None:
    """Fill ``xi`` (2, 2), m: [0] wheels and [1] rails, at ``step``, without the force of that step itself."""
    coming = dynamics.coming
    xi[0, 0], xi[0, 1], xi[1, 0], xi[1, 1] = coming[0, 0], coming[0, 1], coming[1, 0], coming[1, 1]


@summing_kernel
def advance(dynamics: Causal, step: int, forces: np.ndarray) -> None:
    """Apply the ``forces``, (2,), N, of ``step``: advance all modes to the next one and fill ``coming`` for it."""
    coming, one, two = dynamics.coming, forces[0], forces[1]
    coming[0, 0], coming[0, 1] = advance_wheels(dynamics, one, two)
    place = dynamics.places[step % dynamics.places.shape[0]]
    even = _advance_half(dynamics.track[0], place[0], dynamics.track_modes, (one + two) / 2)
    odd = _advance_half(dynamics.track[1], place[1], dynamics.track_modes, (one - two) / 2)
    coming[1, 0], coming[1, 1] = even + odd, even - odd


@summing_kernel
def advance_wheels(dynamics: Any, one: float, two: float) -> tuple[float, float]:
    """Apply the forces of wheel 1 and 2, N, to the wheelset's modes; returns its coming displacements, m."""
    xi_1 = xi_2 = 0.0
    for bank in range(dynamics.wheels.shape[0]):
        w = dynamics.wheels[bank]
        for p in range(min(ROW, dynamics.wheel_modes - bank * ROW)):
            re, im, a_re, a_im = w[p], w[ROW + p], w[2 * ROW + p], w[3 * ROW + p]
            real = a_re * re - a_im * im + w[4 * ROW + p] * one + w[6 * ROW + p] * two
            imag = a_re * im + a_im * re + w[5 * ROW + p] * one + w[7 * ROW + p] * two
            w[p], w[ROW + p] = real, imag
            xi_1 += w[8 * ROW + p] * real - w[9 * ROW + p] * imag
            xi_2 += w[10 * ROW + p] * real - w[11 * ROW + p] * imag
    return xi_1, xi_2


@summing_kernel
def _advance_half(half: np.ndarray, place: np.ndarray, modes: int, force: float) -> float:
    """Apply the force, N, of one half of the track at a ``place``; returns its coming displacement, m."""
    xi = 0.0
    for bank in range(half.shape[0]):
        h, at = half[bank], place[bank]
        for q in range(min(ROW, modes - bank * ROW)):
            re, im, a_re, a_im = h[q], h[ROW + q], h[2 * ROW + q], h[3 * ROW + q]
            real = a_re * re - a_im * im + at[q] * force
            imag = a_re * im + a_im * re + at[ROW + q] * force
            h[q], h[ROW + q] = real, imag
            xi += at[2 * ROW + q] * real - at[3 * ROW + q] * imag
    return xi


@summing_kernel
def stresses(dynamics: Any, forces: np.ndarray, stress: np.ndarray) -> None:
    """Fill ``stress`` (S,) Pa at the step whose ``forces`` (2,) N are given; before ``advance``."""
    direct, one, two = dynamics.stress_direct, forces[0], forces[1]
    for group in range(dynamics.stress_output.shape[0]):
        # Four sums at a time: each mode is loaded once for them, and no sum waits for its last addition.
        sum_0 = sum_1 = sum_2 = sum_3 = 0.0
        for bank in range(dynamics.stress_output.shape[1]):
            w, out = dynamics.wheels[bank], dynamics.stress_output[group, bank]
            for p in range(min(ROW, dynamics.stress_modes - bank * ROW)):
                re, im = w[p], w[ROW + p]
                sum_0 += out[p] * re - out[ROW + p] * im
                sum_1 += out[2 * ROW + p] * re - out[3 * ROW + p] * im
                sum_2 += out[4 * ROW + p] * re - out[5 * ROW + p] * im
                sum_3 += out[6 * ROW + p] * re - out[7 * ROW + p] * im
        for offset, total in enumerate((sum_0, sum_1, sum_2, sum_3)):
            s = 4 * group + offset
            if s < stress.size:
                stress[s] = total + direct[s, 0] * one + direct[s, 1] * two


@summing_kernel
def sensed(dynamics: Any, forces: np.ndarray, signals: np.ndarray) -> None:
    """Fill ``signals`` (rows,) of sensors at the step whose ``forces`` (2,) N are given; before ``advance``."""
    direct, one, two = dynamics.sensor_direct, forces[0], forces[1]
    for pair in range(dynamics.sensor_output.shape[0]):
        # Real and imaginary parts apart, so that no sum waits for another one.
        real_0 = real_1 = imag_0 = imag_1 = 0.0
        for bank in range(dynamics.sensor_output.shape[1]):
            w, out = dynamics.wheels[bank], dynamics.sensor_output[pair, bank]
            for p in range(min(ROW, dynamics.sensor_modes - bank * ROW)):
                re, im = w[p], w[ROW + p]
                real_0 += out[p] * re
                imag_0 += out[ROW + p] * im
                real_1 += out[2 * ROW + p] * re
                imag_1 += out[3 * ROW + p] * im
        for offset, total in enumerate((real_0 - imag_0, real_1 - imag_1)):
            row = 2 * pair + offset
            if row < signals.size:
                signals[row] = total + direct[row, 0] * one + direct[row, 1] * two
