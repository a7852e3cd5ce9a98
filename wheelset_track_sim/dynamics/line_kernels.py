"""The ``line`` dynamics step by step: the interface of the coupled step, and how the bays move on.

``line`` explains the method, ``line_bay_kernels`` the layout of bays in memory.
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
    """What follows from the speed; N bays of the bays, L places around a sleeper."""

    dt: float
    inertia: np.ndarray  # (RAIL_MODES,) of a mode with its stiffness
    pushes: np.ndarray  # (L, 6) on three nodes by a unit force at a place, modes condensed
    own: np.ndarray  # (L,) m/N of modes and residual at the step of the force
    factors: np.ndarray  # (FACTORS + 32, N)
    middle: np.ndarray  # (N, 12, 12) inverse of the inertia of three nodes


class Bays(NamedTuple):
    """State and coefficients of the bays at hand.

    The state is the predictor at the coming step: deflections and velocities but for its accelerations.
    """

    coming: np.ndarray  # (2, 2) m displacements of wheels and rails at the coming step, but for its own force
    rail_compliance: np.ndarray  # (1,) m/N of the force at the coming step, mean of both rails
    deflection: np.ndarray  # (ROWS COLUMNS,)
    velocity: np.ndarray  # (ROWS COLUMNS,)
    acceleration: np.ndarray  # (ROWS COLUMNS,)
    load: np.ndarray  # (ROWS COLUMNS,) N on the unknowns at the coming step, but for the wheels
    work: np.ndarray  # ((4 HALF + 4) COLUMNS,)
    window: np.ndarray  # (FACTORS COLUMNS,) of the bays at hand
    hub: np.ndarray  # (12, 12) ``middle`` of the bay at hand
    push: np.ndarray  # (7 + 3 RAIL_MODES,) of the coming step: dt, inertia, pushes, shapes of modes
    at: np.ndarray  # (2,) sleeper in the middle at the coming step; 0 if the window is not that of ``steps``
    parts: LineParts
    steps: LineSteps


class Line(NamedTuple):
    """The whole system: the wheelset as in ``causal_kernels.Causal``, arrays of ``bays`` that are looked at."""

    wheels: np.ndarray
    wheel_modes: int
    stress_output: np.ndarray
    stress_modes: int
    stress_direct: np.ndarray
    wheel_compliance: np.ndarray
    coming: np.ndarray
    rail_compliance: np.ndarray
    bays: Bays
    move: Any  # ``move`` by its address: who steps is compiled without it
    speed: float  # m/s


displacements = causal_kernels.displacements
stresses = causal_kernels.stresses


@summing_kernel
def advance(dynamics: Line, step: int, forces: np.ndarray) -> None:
    """Take in the ``forces`` (2,) N of ``step`` and move on to the next one."""
    coming, one, two = dynamics.coming, forces[0], forces[1]
    coming[0, 0], coming[0, 1] = advance_wheels(dynamics, one, two)
    dynamics.move(dynamics.bays, step + 1, one, two)


@block_kernel
def move(bays: Bays, step: int, one: float, two: float) -> int:
    """Take in the forces of wheel 1 and 2, N, at the coming step, and move on to ``step``, which then comes."""
    _accelerate(bays, one, two)
    _foresee(bays, step)
    return step


@summing_kernel
def _foresee(bays: Bays, step: int) -> None:
    """From the motion of the step before: the predictor of ``step``, its loads, and what the rails displace there."""
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
    """Copy what belongs to the bays at hand."""
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
    """Fill ``coming``, ``rail_compliance`` and ``push`` for the coming step at a ``place`` around the sleeper."""
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
    """Accelerations at the step whose predictor is at hand, under the forces of both wheels, N; correct the motion."""
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
