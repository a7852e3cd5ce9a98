"""The ``line`` dynamics step by step: what the wheels' forces do to the bays, and how the bays move on.

``line_bay_kernels`` derives the step of the bays and has the symbols; ``causal_kernels`` steps the wheelset.

Force and deflection. A force F on a rail at a place x acts on w and theta of three nodes with the shapes phi_e, (6,),
and on the modes of the spans behind and ahead with the shapes phi_i. Condensed onto the nodes it is psi F::

    psi = phi_e - sum_i c_i phi_i / m_i                                                   ``LineSteps.pushes``

Let g be the loads without F condensed into the three nodes, and H (12, 12) the inverse of their inertia (``hub``). Then
a_nodes = H (g + psi F) and a_i = (f_i + phi_i F - c_i.a_ends) / m_i, so the rail deflects at x, at that step, by::

    xi = phi.u' = phi.u* + dt^2/12 phi.a'
       = [phi.u* + dt^2/12 (psi.H g + sum_i phi_i f_i / m_i)]                             ``Bays.coming``
       + [dt^2/12 (psi.H psi + sum_i phi_i^2 / m_i) + static residual of higher modes] F  ``Bays.rail_compliance``

The first part is known before F. The second is a compliance, with which the contact is solved. So the force of a step
moves the bays at that step, without an iteration between contact and track.

Approximations. The compliance is the mean over both rails, which differ where their supports do: by 4e-4 with a scatter
of the pads of 20 % at 100 km/h. What a force does to the other rail at once, less than 1e-5 of that, is left out.

Moving on. When the wheels have passed the middle between two sleepers, all columns move on by one, and the factors of
the bays now at hand are copied into ``window``. The column that comes in ahead is at rest.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..runtime.jit import block_kernel, summing_kernel
from . import causal_kernels
from .causal_kernels import advance_wheels
from .line_bay_kernels import (
    COLUMNS,
    FACTORS,
    MIDDLE,
    NODES,
    RAIL_MODES,
    ROWS,
    SOLVE,
    LineParts,
    correct,
    load_hanging,
    load_pads,
    load_rails,
    load_sleepers,
    predict,
    spread,
    spread_in_bays,
    sweep,
)


class LineSteps(NamedTuple):
    """What follows from the speed; N bays of the line, L places around a sleeper."""

    dt: float  # s
    inertia: np.ndarray  # (RAIL_MODES,) m_i, with kappa times the stiffness of the mode
    pushes: np.ndarray  # (L, 6) psi at a place
    own: np.ndarray  # (L,) m/N, dt^2/12 sum_i phi_i^2 / m_i and the static residual
    factors: np.ndarray  # (FACTORS + 32, N), rows as in ``line_bay_kernels``
    middle: np.ndarray  # (N, 12, 12) H around each sleeper


class Bays(NamedTuple):
    """State and coefficients of the bays at hand.

    The state is the predictor u*, v* of the coming step, whose accelerations depend on the forces to come.
    """

    coming: np.ndarray  # (2, 2) m displacements of wheels and rails at the coming step, without its own force
    rail_compliance: np.ndarray  # (1,) m/N of the force at the coming step, mean of both rails
    deflection: np.ndarray  # (ROWS COLUMNS,) u*
    velocity: np.ndarray  # (ROWS COLUMNS,) v*
    acceleration: np.ndarray  # (ROWS COLUMNS,) a of the step before
    load: np.ndarray  # (ROWS COLUMNS,) loads at the coming step, without the wheels', condensed into the middle
    work: np.ndarray  # ((4 HALF + 4) COLUMNS,) scratch
    window: np.ndarray  # (FACTORS COLUMNS,) factors of the bays at hand
    hub: np.ndarray  # (12, 12) H of the bay at hand
    push: np.ndarray  # (7 + 3 RAIL_MODES,) of the coming step: dt, m_i, psi, phi_i
    at: np.ndarray  # (2,) sleeper in the middle at the coming step; 1 if the window is that of ``steps``, else 0
    parts: LineParts
    steps: LineSteps


class Line(NamedTuple):
    """The whole system: the wheelset as in ``causal_kernels.Causal``, and the bays.

    ``coming`` and ``rail_compliance`` are the arrays of ``bays``.
    """

    wheels: np.ndarray
    wheel_modes: int
    stress_output: np.ndarray
    stress_modes: int
    stress_direct: np.ndarray
    sensor_output: np.ndarray
    sensor_modes: int
    sensor_direct: np.ndarray
    wheel_compliance: np.ndarray
    coming: np.ndarray
    rail_compliance: np.ndarray
    bays: Bays
    move: Any  # ``move`` by its address, so that the stepping loop is compiled without it
    speed: float  # m/s


displacements = causal_kernels.displacements
stresses = causal_kernels.stresses
sensed = causal_kernels.sensed


@summing_kernel
def advance(dynamics: Line, step: int, forces: np.ndarray) -> None:
    """Apply the ``forces``, (2,), N, of ``step`` and move on to the next one."""
    coming, one, two = dynamics.coming, forces[0], forces[1]
    coming[0, 0], coming[0, 1] = advance_wheels(dynamics, one, two)
    dynamics.move(dynamics.bays, step + 1, one, two)


@block_kernel
def move(bays: Bays, step: int, one: float, two: float) -> int:
    """Apply the forces of wheel 1 and 2, N, at the coming step, and move on to ``step``, the next one; returns it."""
    _accelerate(bays, one, two)
    _foresee(bays, step)
    return step


@summing_kernel
def _foresee(bays: Bays, step: int) -> None:
    """From the motion of the step before, find the predictor of ``step``, its loads and the coming displacements."""
    places = bays.parts.shapes.shape[0]
    from_first = step + places // 2
    sleeper = from_first // places
    if sleeper != bays.at[0]:
        for motion in (bays.deflection, bays.velocity, bays.acceleration):
            for row in range(0, ROWS * COLUMNS, COLUMNS):
                for b in range(row, row + COLUMNS - 1):
                    motion[b] = motion[b + 1]
        bays.at[0], bays.at[1] = sleeper, 0
    if bays.at[1] == 0:
        _take_factors(bays)
        bays.at[1] = 1
    predict(bays.deflection, bays.velocity, bays.acceleration, bays.steps.dt)
    if bays.parts.nodes.shape[0] > 0:
        load_sleepers(bays.parts, bays.window, bays.deflection, bays.velocity, bays.load, bays.work)
        load_hanging(bays.parts, bays.window, bays.deflection, bays.velocity, bays.load)
    else:
        load_pads(bays.parts, bays.window, bays.deflection, bays.velocity, bays.load)
    load_rails(bays.parts, bays.steps.inertia, bays.window, bays.deflection, bays.load)
    sweep(bays.window, bays.load)
    _see(bays, from_first - sleeper * places)


@summing_kernel
def _take_factors(bays: Bays) -> None:
    """Copy the factors of the bays at hand into ``window`` and ``hub``."""
    factors, count = bays.steps.factors, bays.steps.factors.shape[1]
    for b in range(NODES):
        bay = (bays.at[0] - MIDDLE + b) % count
        for row in range(SOLVE):
            bays.window[row * COLUMNS + b] = factors[row, bay]
        first = SOLVE if b < MIDDLE else FACTORS
        for row in range(32):
            bays.window[(SOLVE + row) * COLUMNS + b] = factors[first + row, bay]
    bays.hub[:] = bays.steps.middle[bays.at[0] % count]


@summing_kernel
def _see(bays: Bays, place: int) -> None:
    """Fill ``coming``, ``rail_compliance`` and ``push`` for the coming step at a ``place``, 0 to L - 1."""
    n, m, load, u, hub, push = COLUMNS, RAIL_MODES, bays.load, bays.deflection, bays.hub, bays.push
    shape, pushes, inertia = bays.parts.shapes[place], bays.steps.pushes[place], bays.steps.inertia
    at_once = bays.steps.dt * bays.steps.dt / 12.0
    push[0] = bays.steps.dt
    for i in range(m):
        push[1 + i] = inertia[i]
    for i in range(6):
        push[1 + m + i] = pushes[i]
    for i in range(2 * m):
        push[7 + m + i] = shape[6 + i]
    compliance = bays.steps.own[place]
    for rail in range(2):
        xi = by_loads = by_force = 0.0
        for mine in range(6):
            row, node = 4 * (mine // 2) + 2 * rail + mine % 2, MIDDLE - 1 + mine // 2
            acceleration = pushed = 0.0
            for other in range(3):
                for j in range(4):
                    acceleration += hub[row, 4 * other + j] * load[j * n + MIDDLE - 1 + other]
                for j in range(2):
                    pushed += hub[row, 4 * other + 2 * rail + j] * pushes[2 * other + j]
            xi += shape[mine] * u[(2 * rail + mine % 2) * n + node]
            by_loads += pushes[mine] * acceleration
            by_force += pushes[mine] * pushed
        for i in range(2 * m):
            at = (4 + m * rail + i % m) * n + MIDDLE - 1 + i // m
            xi += shape[6 + i] * u[at]
            by_loads += shape[6 + i] * load[at] / inertia[i % m]
        bays.coming[1, rail] = xi + at_once * by_loads
        compliance += at_once * by_force / 2.0
    bays.rail_compliance[0] = compliance


@summing_kernel
def _accelerate(bays: Bays, one: float, two: float) -> None:
    """Solve for the accelerations of the step at hand under the forces of both wheels, N, and correct the motion."""
    n, m, load, push, a = COLUMNS, RAIL_MODES, bays.load, bays.push, bays.acceleration
    for rail in range(2):
        force = one if rail == 0 else two
        for i in range(6):
            load[(2 * rail + i % 2) * n + MIDDLE - 1 + i // 2] += push[1 + m + i] * force
        for i in range(2 * m):
            load[(4 + m * rail + i % m) * n + MIDDLE - 1 + i // m] += push[7 + m + i] * force
    for i in range(12):
        total = 0.0
        for other in range(3):
            for j in range(4):
                total += bays.hub[i, 4 * other + j] * load[j * n + MIDDLE - 1 + other]
        a[i % 4 * n + MIDDLE - 1 + i // 4] = total
    spread(bays.window, load, a)
    spread_in_bays(bays.parts.coupling, push, bays.window, load, a)
    correct(bays.deflection, bays.velocity, a, push[0])
