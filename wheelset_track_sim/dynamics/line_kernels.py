"""The ``line`` dynamics step by step: what the wheels' forces do to the bays, and how the bays move on.

``line_bay_kernels`` derives the step of the bays and has the symbols; ``causal_kernels`` steps the wheelset.

Force and deflection. A force F on a rail at a place x acts on w and theta of three nodes with the shapes phi_e, (6,),
and on the modes of the spans behind and ahead with the shapes phi_i. Condensed onto the nodes it is psi F::

    psi = phi_e - sum_i c_i phi_i / m_i                                                   ``LineSteps.pushes``

Let g be the loads without F condensed into the three nodes, and H (12, 12) the inverse of their inertia (``hub``). Then
a_nodes = H (g + psi F) and a_i = -e_i + (phi_i F - c_i.a_ends) / m_i, so the rail deflects at x, at that step, by::

    xi = phi.u' = phi.u* + dt^2/12 phi.a'
       = [phi.u* + dt^2/12 (psi.H g - sum_i phi_i e_i)]                                   ``Bays.coming``
       + [dt^2/12 (psi.H psi + sum_i phi_i^2 / m_i) + static residual of higher modes] F  ``Bays.rail_compliance``

The first part is known before F. The second is a compliance, with which the contact is solved. So the force of a step
moves the bays at that step, without an iteration between contact and track.

Approximations. The compliance is the mean over both rails, which differ where their supports do: by 4e-4 with a scatter
of the pads of 20 % at 100 km/h. What a force does to the other rail at once, less than 1e-5 of that, is left out.

Hanging sleepers. The push of the ballast follows from u* and v* of the sleeper, x = T r. What it adds to the loads and
to the coming state, ``LineSteps.hang``, is added to what the linear step does.

Moving on. When the wheels have passed the middle between two sleepers, all columns move on by one, and the factors of
the bays now at hand are copied into ``window``. The column that comes in ahead is at rest.

Change of speed. The predictor depends on the step to come, and so do the sleepers' states r. At the step at which dt
changes to q dt, sleepers advance as ever, from y to y' in x = [u*, y], so dt^2 a = y' - y. The predictor of a step of
q dt follows from that, and is brought into the new basis::

    y <- q (y + (1 + q)/2 dt^2 a),    u* <- u* + q y + (1/12 + q/2 + 5/12 q^2) dt^2 a
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..runtime.jit import bare_kernel, summing_kernel
from . import causal_kernels
from .causal_kernels import advance_wheels
from .line_bay_kernels import (
    BACK,
    BEFORE,
    COLUMNS,
    FACTORS,
    HALF,
    KEPT,
    LOAD,
    MIDDLE,
    NODES,
    OUTPUT,
    RAIL_MODES,
    SOLVE,
    STATES,
    A,
    LineParts,
    R,
    U,
    V,
    advance_rails,
    advance_sleepers,
    load_nodes,
    load_spans,
    spread,
    sweep,
)


class LineSteps(NamedTuple):
    """What follows from the speed; N bays of the line, H of them with hanging sleepers, L places around a sleeper."""

    dt: float  # s
    inertia: np.ndarray  # (RAIL_MODES,) m_i, with kappa times the stiffness of the mode
    squared: np.ndarray  # (RAIL_MODES,) omega_i^2 / m_i, 1/s^2
    pushes: np.ndarray  # (L, 6) psi at a place
    own: np.ndarray  # (L,) m/N, dt^2/12 sum_i phi_i^2 / m_i and the static residual
    factors: np.ndarray  # (FACTORS + 16, N), rows as in ``line_bay_kernels``
    chain: np.ndarray  # (2, N, 32) P^-1 T and its transpose, of nodes behind the wheels and ahead
    middle: np.ndarray  # (N, 12, 12) H around each sleeper
    shapes: np.ndarray  # (N, STATES, STATES) T; none on slab track
    states: np.ndarray  # (N, STATES, STATES) its inverse
    hanging: np.ndarray  # (N,) number of the hanging sleeper, or -1
    hang: np.ndarray  # (H, STATES + 2, 2 HALF) what loads on its modes add to its coming state, and to the rails' loads
    beds: np.ndarray  # (H, 2, 3) gap, m, stiffness and damping of the ballast on either side; a gap of NaN is none


class Bays(NamedTuple):
    """State and coefficients of the bays at hand.

    The state is the predictor of the coming step, whose accelerations depend on the forces to come.
    """

    coming: np.ndarray  # (2, 2) m displacements of wheels and rails at the coming step, without its own force
    rail_compliance: np.ndarray  # (1,) m/N of the force at the coming step, mean of both rails
    motion: np.ndarray  # (ROWS COLUMNS,) state and scratch, rows as in ``line_bay_kernels``
    window: np.ndarray  # (FACTORS COLUMNS,) factors of the bays at hand
    chain: np.ndarray  # (COLUMNS, 32) P^-1 T of the bays at hand
    hub: np.ndarray  # (12, 12) H of the bay at hand
    work: np.ndarray  # (3, 12) scratch: loads in the middle; H psi of both rails
    hung: np.ndarray  # (COLUMNS + 1,) number of hanging sleepers at hand, and their columns
    push: np.ndarray  # (COLUMNS, STATES + 2) what the ballast of each adds to its coming state and to the rails' loads
    nodes: np.ndarray  # (2 STATES + 3 nodes,) scratch: x and loads of a sleeper; u, v and push of its nodes
    at: np.ndarray  # (2,) sleeper in the middle at the coming step; 1 if the window is that of ``steps``, else 0
    parts: LineParts
    steps: LineSteps  # from the coming step on
    before: LineSteps  # up to the coming step; others if the speed changes there


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


@bare_kernel
def move(bays: Bays, step: int, one: float, two: float) -> int:
    """Apply the forces of wheel 1 and 2, N, at the coming step, and move on to ``step``, the next one; returns it.

    At the start, where rows R hold x of sleepers at rest and no window has been taken yet, nothing is applied.
    """
    if bays.at[1] != 0:
        _accelerate(bays, step - 1, one, two)
    _foresee(bays, step)
    return step


@bare_kernel
def _accelerate(bays: Bays, step: int, one: float, two: float) -> None:
    """Solve for the accelerations of ``step`` under the forces of both wheels, N, and advance the motion."""
    n, k, m, before = COLUMNS, RAIL_MODES, bays.motion, bays.before
    places, changes = bays.parts.shapes.shape[0], bays.steps.dt != before.dt
    place = step + places // 2 - bays.at[0] * places
    loads, phi, psi = bays.work[0], bays.parts.shapes[place], before.pushes[place]
    for i in range(6):
        loads[4 * (i // 2) + i % 2] += psi[i] * one
        loads[4 * (i // 2) + 2 + i % 2] += psi[i] * two
    for i in range(12):
        total = 0.0
        for j in range(12):
            total += bays.hub[i, j] * loads[j]
        m[(A + i % 4) * n + MIDDLE - 1 + i // 4] = total
    spread(bays.window, bays.chain, m)
    advance_rails(bays.parts, before.squared, before.inertia, before.dt, bays.steps.dt, m)
    dt, next_dt = before.dt, bays.steps.dt
    faster, farther = (dt + next_dt) / 2.0, dt * dt / 12.0 + dt * next_dt / 2.0 + next_dt * next_dt * (5.0 / 12.0)
    for i in range(2 * k):
        own = phi[6 + i] / before.inertia[i % k]
        for rail in range(2):
            at, force = (4 + k * rail + i % k) * n + MIDDLE - 1 + i // k, one if rail == 0 else two
            m[U * n + at] += farther * own * force
            m[V * n + at] += faster * own * force
    if bays.parts.nodes.shape[1] > 0:
        if changes:
            for i in range(STATES * n):
                m[BEFORE * n + i] = m[R * n + i]
        advance_sleepers(bays.window, m)
        for i in range(bays.hung[0]):
            b, back1, back2 = bays.hung[1 + i], 0.0, 0.0
            for j in range(STATES):
                pushed, o = bays.push[i, j], (OUTPUT + 4 * (j // 2) + 2 * (j % 2)) * n + b
                m[(R + j) * n + b] += pushed
                back1 += bays.window[o] * pushed
                back2 += bays.window[o + n] * pushed
            m[BACK * n + b] += back1
            m[(BACK + 1) * n + b] += back2
        if changes:
            _leave_basis(bays)
    if changes:
        bays.at[1] = 0


@bare_kernel
def _leave_basis(bays: Bays) -> None:
    """Replace the states R after the step by x of the predictor for a step of another length."""
    n, m, old = COLUMNS, bays.motion, bays.before
    q, count, half = bays.steps.dt / old.dt, old.shapes.shape[0], 2 * HALF
    for b in range(NODES):
        shapes = old.shapes[(bays.at[0] - MIDDLE + b) % count]
        for i in range(half):
            u = y = y_next = 0.0
            for j in range(STATES):
                u += shapes[i, j] * m[(BEFORE + j) * n + b]
                y += shapes[half + i, j] * m[(BEFORE + j) * n + b]
                y_next += shapes[half + i, j] * m[(R + j) * n + b]
            bays.nodes[i] = u + q * y + (1.0 / 12.0 + q / 2.0 + q * q * (5.0 / 12.0)) * (y_next - y)
            bays.nodes[half + i] = q * (y + (1.0 + q) / 2.0 * (y_next - y))
        for i in range(STATES):
            m[(R + i) * n + b] = bays.nodes[i]


@bare_kernel
def _enter_basis(bays: Bays) -> None:
    """Replace x in the rows R by the states of ``steps``, and fill BACK."""
    n, m, f, new = COLUMNS, bays.motion, bays.window, bays.steps
    for b in range(NODES):
        states = new.states[(bays.at[0] - MIDDLE + b) % new.states.shape[0]]
        back1 = back2 = 0.0
        for i in range(STATES):
            r, o = 0.0, (OUTPUT + 4 * (i // 2) + 2 * (i % 2)) * n + b
            for j in range(STATES):
                r += states[i, j] * m[(R + j) * n + b]
            bays.nodes[i] = r
            back1 += f[o] * r
            back2 += f[o + n] * r
        for i in range(STATES):
            m[(R + i) * n + b] = bays.nodes[i]
        m[BACK * n + b], m[(BACK + 1) * n + b] = back1, back2


@bare_kernel
def _foresee(bays: Bays, step: int) -> None:
    """From the predictor of ``step`` find its loads and the coming displacements."""
    m, places, n = bays.motion, bays.parts.shapes.shape[0], COLUMNS
    from_first = step + places // 2
    sleeper = from_first // places
    if sleeper != bays.at[0] or bays.at[1] == 0:
        if sleeper != bays.at[0]:
            for row in range(0, KEPT * n, n):
                for b in range(row, row + n - 1):
                    m[b] = m[b + 1]
        bays.at[0] = sleeper
        _take_factors(bays)
        if bays.at[1] == 0 and bays.parts.nodes.shape[1] > 0:
            _enter_basis(bays)
        bays.at[1] = 1
    load_spans(bays.parts, bays.steps.squared, m)
    load_nodes(bays.parts, bays.window, m)
    for i in range(bays.hung[0]):
        _load_hanging(bays, i)
    sweep(bays.chain, m)
    _see(bays, from_first - sleeper * places)


@bare_kernel
def _take_factors(bays: Bays) -> None:
    """Copy the factors of the bays at hand into ``window``, ``chain`` and ``hub``, and list their hanging sleepers."""
    steps = bays.steps
    factors, count = steps.factors, steps.factors.shape[1]
    bays.hung[0] = 0
    for b in range(NODES):
        bay = (bays.at[0] - MIDDLE + b) % count
        for row in range(SOLVE):
            bays.window[row * COLUMNS + b] = factors[row, bay]
        first, side = (SOLVE, 0) if b < MIDDLE else (FACTORS, 1)
        for row in range(16):
            bays.window[(SOLVE + row) * COLUMNS + b] = factors[first + row, bay]
        for i in range(32):
            bays.chain[b, i] = steps.chain[side, bay, i]
        if steps.hanging[bay] >= 0:
            bays.hung[0] += 1
            bays.hung[bays.hung[0]] = b
    for i in range(12):
        for j in range(12):
            bays.hub[i, j] = steps.middle[bays.at[0] % count, i, j]


@bare_kernel
def _load_hanging(bays: Bays, number: int) -> None:
    """Load one of the hanging sleepers at hand: ballast pushes where the gap is closed, and never pulls.

    A node of the sleeper with the deflection u and the rate v is pushed with its share of k (u - gap) + c v where both
    u > gap and this force is positive.
    """
    n, m, steps, half, nodes = COLUMNS, bays.motion, bays.steps, 2 * HALF, bays.parts.nodes
    b, count = bays.hung[1 + number], nodes.shape[1]
    bay = (bays.at[0] - MIDDLE + b) % steps.hanging.shape[0]
    hanging, shapes = steps.hanging[bay], steps.shapes[bay]
    x, f = bays.nodes[:STATES], bays.nodes[STATES : 2 * STATES]
    deflection, rate, push = (
        bays.nodes[2 * STATES : 2 * STATES + count],
        bays.nodes[2 * STATES + count : 2 * STATES + 2 * count],
        bays.nodes[2 * STATES + 2 * count :],
    )
    for j in range(STATES):
        f[j] = m[(R + j) * n + b]
    for i in range(STATES):
        total = 0.0
        for j in range(STATES):
            total += shapes[i, j] * f[j]
        x[i] = total
    for node in range(count):
        deflection[node] = rate[node] = push[node] = 0.0
    for j in range(half):
        u, v = x[j], x[half + j] / steps.dt
        for node in range(count):
            deflection[node] += nodes[j, node] * u
            rate[node] += nodes[j, node] * v
    for side in range(2):
        bed = steps.beds[hanging, side]
        gap, stiffness, damping = bed[0], bed[1], bed[2]
        if np.isnan(gap):
            continue
        for node in range(count):
            force = bays.parts.shares[side, node] * (stiffness * (deflection[node] - gap) + damping * rate[node])
            if deflection[node] > gap and force > 0.0:
                push[node] += force
    for j in range(half):
        total = 0.0
        for node in range(count):
            total -= nodes[j, node] * push[node]
        f[j] = total
    for i in range(STATES + 2):
        total = 0.0
        for j in range(half):
            total += steps.hang[hanging, i, j] * f[j]
        bays.push[number, i] = total
    m[LOAD * n + b] += bays.push[number, STATES]
    m[(LOAD + 2) * n + b] += bays.push[number, STATES + 1]


@bare_kernel
def _see(bays: Bays, place: int) -> None:
    """Fill ``coming`` and ``rail_compliance`` for the coming step at a ``place``, 0 to L - 1."""
    n, k, m, steps = COLUMNS, RAIL_MODES, bays.motion, bays.steps
    phi, psi, loads = bays.parts.shapes[place], steps.pushes[place], bays.work[0]
    at_once = steps.dt * steps.dt / 12.0
    compliance = steps.own[place]
    for i in range(12):
        loads[i] = m[(LOAD + i % 4) * n + MIDDLE - 1 + i // 4]
    for rail in range(2):
        pushed = bays.work[1 + rail]
        for j in range(12):
            total = 0.0
            for i in range(6):
                total += psi[i] * bays.hub[4 * (i // 2) + 2 * rail + i % 2, j]
            pushed[j] = total
        xi = by_loads = by_force = 0.0
        for j in range(12):
            by_loads += pushed[j] * loads[j]
        for i in range(6):
            by_force += psi[i] * pushed[4 * (i // 2) + 2 * rail + i % 2]
            xi += phi[i] * m[(U + 2 * rail + i % 2) * n + MIDDLE - 1 + i // 2]
        for i in range(2 * k):
            u = m[(U + 4 + k * rail + i % k) * n + MIDDLE - 1 + i // k]
            xi += phi[6 + i] * u
            by_loads -= phi[6 + i] * steps.squared[i % k] * u
        bays.coming[1, rail] = xi + at_once * by_loads
        compliance += at_once * by_force / 2.0
    bays.rail_compliance[0] = compliance
