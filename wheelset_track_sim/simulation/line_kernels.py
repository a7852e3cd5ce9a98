"""The ``line`` dynamics step by step: the interface of the coupled step, and how the bays move on.

``line`` explains the method, ``line_bay_kernels`` the layout of bays in memory.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..jit import block_kernel, summing_kernel
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

    dt: float
    inertia: np.ndarray  # (RAIL_MODES,) of a mode with its stiffness
    pushes: np.ndarray  # (L, 6) on three nodes by a unit force at a place, modes condensed
    own: np.ndarray  # (L,) m/N of modes and residual at the step of the force
    factors: np.ndarray  # (FACTORS + 32, N)
    middle: np.ndarray  # (N, 12, 12) inverse of the inertia of three nodes


class Line(NamedTuple):
    """State and coefficients; the wheelset as in ``causal_kernels.Causal``.

    The state is the predictor at the coming step: deflections and velocities but for its accelerations.
    """

    wheels: np.ndarray
    wheel_modes: int
    stress_output: np.ndarray
    stress_modes: int
    stress_direct: np.ndarray
    wheel_compliance: np.ndarray
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
    speed: float  # m/s


displacements = causal_kernels.displacements
stresses = causal_kernels.stresses


@summing_kernel
def advance(dynamics: Line, step: int, forces: np.ndarray) -> None:
    """Take in the ``forces`` (2,) N of ``step`` and move on to the next one."""
    coming = dynamics.coming
    coming[0, 0], coming[0, 1] = advance_wheels(dynamics, forces[0], forces[1])
    accelerate(dynamics, forces[0], forces[1])
    foresee(dynamics, step + 1)


@block_kernel
def foresee(line: Line, step: int) -> None:
    """From the motion of the step before: the predictor of ``step``, its loads, and what the rails displace there."""
    places = line.parts.shapes.shape[0]
    from_first = step + places // 2
    sleeper = from_first // places
    if sleeper != line.at[0]:
        for motion in (line.deflection, line.velocity, line.acceleration):
            for row in range(0, ROWS * COLUMNS, COLUMNS):
                for b in range(row, row + COLUMNS - 1):
                    motion[b] = motion[b + 1]
        line.at[0], line.at[1] = sleeper, 0
    if line.at[1] == 0:
        _take_factors(line)
        line.at[1] = 1
    predict(line.deflection, line.velocity, line.acceleration, line.steps.dt)
    if line.parts.nodes.shape[0] > 0:
        load_sleepers(line.parts, line.window, line.deflection, line.velocity, line.load, line.work)
        load_hanging(line.parts, line.window, line.deflection, line.velocity, line.load)
    else:
        load_pads(line.parts, line.window, line.deflection, line.velocity, line.load)
    load_rails(line.parts, line.steps.inertia, line.window, line.deflection, line.load)
    sweep(line.window, line.load)
    _see(line, from_first - sleeper * places)


@summing_kernel
def _take_factors(line: Line) -> None:
    """Copy what belongs to the bays at hand."""
    factors, bays = line.steps.factors, line.steps.factors.shape[1]
    for b in range(NODES):
        bay = (line.at[0] - MIDDLE + b) % bays
        for row in range(SOLVE):
            line.window[row * COLUMNS + b] = factors[row, bay]
        first = SOLVE if b < MIDDLE else FACTORS
        for row in range(32):
            line.window[(SOLVE + row) * COLUMNS + b] = factors[first + row, bay]
    line.hub[:] = line.steps.middle[line.at[0] % bays]


@summing_kernel
def _see(line: Line, place: int) -> None:
    """Fill ``coming``, ``rail_compliance`` and ``push`` for the coming step at a ``place`` around the sleeper."""
    n, m, load, u, hub, push = COLUMNS, RAIL_MODES, line.load, line.deflection, line.hub, line.push
    shape, pushes, inertia = line.parts.shapes[place], line.steps.pushes[place], line.steps.inertia
    at_once = line.steps.dt * line.steps.dt / 12.0
    push[0] = line.steps.dt
    for i in range(m):
        push[1 + i] = inertia[i]
    for i in range(6):
        push[1 + m + i] = pushes[i]
    for i in range(2 * m):
        push[7 + m + i] = shape[6 + i]
    compliance = line.steps.own[place]
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
        line.coming[1, rail] = xi + at_once * by_loads
        compliance += at_once * by_force / 2.0
    line.rail_compliance[0] = compliance


@summing_kernel
def accelerate(line: Line, one: float, two: float) -> None:
    """Accelerations at the step whose predictor is at hand, under the forces of both wheels, N; correct the motion."""
    n, m, load, push, a = COLUMNS, RAIL_MODES, line.load, line.push, line.acceleration
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
                total += line.hub[i, 4 * other + j] * load[j * n + MIDDLE - 1 + other]
        a[i % 4 * n + MIDDLE - 1 + i // 4] = total
    spread(line.window, load, a)
    spread_in_bays(line.parts.coupling, push, line.window, load, a)
    correct(line.deflection, line.velocity, a, push[0])
