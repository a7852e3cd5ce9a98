"""Coefficients of the ``line`` dynamics: what a step needs at a speed, bay by bay.

With the inertia ``S = M + dt C / 2 + (1/12 + alpha) dt^2 K`` a step solves ``S a = f``. Modes of rail and sleeper are
condensed into the nodes ``[w, theta]`` of both rails above each sleeper; what is left is a chain of nodes, which is
eliminated from both ends up to the three nodes around the wheels. Neighbouring nodes hardly know of each other within a
step (no wave comes from one to the next), so that what is carried along the chain depends on a few bays only, and is
worked out once for all bays of the line.

Pairs of a sleeper. With a = S^-1 (e g - C v* - K u*), its state x = [u*, y], y = dt v*, advances by::

    y <- y + dt^2 a,  u* <- u* + y      so  x <- x + D x + B g,  D = [[-Q, 1 - P], [-Q, -P]],  B = dt^2 [S^-1 e, S^-1 e]
    Q = dt^2 S^-1 K,  P = dt S^-1 C

A pair of conjugate eigenvectors t +- i s of D makes the columns t and -s of T, two real ones make their own columns. In
r = T^-1 x the pairs advance alone. The pads of stiffness k_r and damping c_r push the rails back by::

    back_r = e_r.(k_r u*_s + c_r v*_s) - p_r e_r.S^-1 (C v*_s + K u*_s) = o_r.r
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.linalg import splu

from ..runtime.arrays import Real
from ..track.line import TrackLine, track_line
from ..track.supports import SupportLine
from ..track.timoshenko import local_flexibility
from .line_bay_kernels import (
    COLUMNS,
    DAMP,
    DIRECT,
    FACTOR,
    GAIN,
    IMPLICIT,
    NODES,
    OUTPUT,
    SOLVE,
    STATES,
    STIFF,
    LineParts,
)
from .line_kernels import LineSteps

END_BAYS = 16
"""Bays at either end with dampers, which grow with the square of the distance from the first of them."""

END_LOSS = (0.2, 0.1)
"""The last damper of a rail's deflection and of its rotation as shares of the rail's impedance to waves of shear and of
rotation. With them the peak of the pinned-pinned resonance errs by 22 % (a ring of 80 bays: 23 %), anything else of the
direct receptance by 3 % at most (by 0.1 % up to 300 Hz)."""

RESOLVED = 2.0
"""Largest ``omega dt`` of the rail's modes between two sleepers."""

STABLE = 5.0
"""Largest ``(omega dt)^2`` of bays; the step itself would bear 6."""

SHORT = 1.25e-4
"""Step, s, from which on the squares of these two fall as it grows. The contact is a spring between bays and wheel that
they do not know of: without this the force of smooth wheels grew without bound under 40 t at 20 km/h."""

PATCH = 0.015
"""Half the length, m, over which shapes of the rail are averaged where a wheel is: about that of the contact."""

CONVERGED = 8
"""Bays after which what is carried along the chain has forgotten where it began."""


@lru_cache(maxsize=8)
def line_parts(line: TrackLine, dx: float) -> LineParts:
    """What is the same in all bays and at all speeds, with shapes at steps of ``dx`` m."""
    span, sleeper, rail = line.span, line.sleeper, line.track.rail
    from_end = np.minimum(np.arange(NODES), np.arange(NODES)[::-1])
    growth = np.zeros(COLUMNS)
    growth[:NODES] = np.maximum(0.0, 1.0 - from_end / END_BAYS) ** 2
    last = np.array(END_LOSS) * 2.0 * np.sqrt([rail.rhoA * rail.kGA, rail.rhoI * rail.EI])
    K = span.stiffness
    return LineParts(
        bend=(K[1, 1] - K[1, 3]) / 2.0,
        shear=np.array([K[0, 0] - K[0, 2], K[0, 1] + K[0, 3], K[1, 1] + K[1, 3]]) / 2.0,
        coupling=np.ascontiguousarray(span.coupling[:2]),
        nodes=np.ascontiguousarray(sleeper.nodes.T),
        shares=sleeper.shares,
        turn=line.track.pad.length**2 / 12.0,
        losses=np.outer(last, growth).ravel(),
        shapes=_shapes(line, dx)[0],
    )


@lru_cache(maxsize=8)
def line_steps(line: TrackLine, residual: bool, dx: float, speed: float) -> LineSteps:
    """Coefficients at ``speed`` m/s; ``residual`` says whether what modes left out deflect is there at once."""
    dt, span = dx / speed, line.span
    share = min(1.0, SHORT / dt)
    inertia = np.maximum(1.0, span.modes * (dt / RESOLVED) ** 2 / share)
    implicit = dt**2 * (1 / 12 + max(0.0, 1 / (STABLE * share) - 1 / (_highest(line, inertia) * dt**2)))
    inertia = inertia + implicit * span.modes
    shapes, static = _shapes(line, dx)
    m = len(inertia)
    pushes = shapes[:, :6].copy()
    for end, modes in ((0, shapes[:, 6 : 6 + m]), (2, shapes[:, 6 + m :])):
        pushes[:, end : end + 4] -= modes / inertia @ span.coupling.T
    sleepers = _sleepers(line, implicit, dt)
    solve, chain, middle = _chain(line, inertia, implicit, dt / 2, sleepers.loss)
    return LineSteps(
        dt=dt,
        inertia=inertia,
        squared=span.modes / inertia,
        pushes=pushes,
        own=dt**2 / 12 * (shapes[:, 6:] ** 2 / np.tile(inertia, 2)).sum(axis=1) + (static if residual else 0.0),
        factors=np.concatenate([sleepers.factors, solve]),
        chain=chain,
        middle=middle,
        shapes=sleepers.shapes,
        states=sleepers.states,
        hanging=sleepers.hanging,
        hang=sleepers.hang,
        beds=np.stack([line.gap, line.ballast_stiffness, line.ballast_damping], axis=2)[sleepers.hanging >= 0],
    )


@lru_cache(maxsize=8)
def _shapes(line: TrackLine, dx: float) -> tuple[Real, Real]:
    """Shapes (L, 6 + 2 m) of three nodes and two spans around a sleeper at steps of ``dx``, and the residual (L,) m/N.

    Higher modes of the rail are left out, and with them most of what a load does close to it; their static share of
    that has a kink above the sleeper, where the modes that are kept have the opposite one, a few steps late. A wheel
    that runs over it would feel a knock of 0.5 % of its load. So shapes are averaged over ``2 PATCH`` around the wheel,
    with weights that leave any cubic as it is, and the residual is what that leaves out of the static deflection of the
    uniform track. Smooth wheels then differ from ``causal`` by 0.2 % of their load at most, up to 200 km/h.
    """
    span, spacing = line.span, line.track.spacing
    places, m = round(spacing / dx), len(span.modes)
    x = np.arange(places + 1) * dx
    own = span.shapes(x)
    both = np.zeros((2 * places + 1, 6 + 2 * m))  # from one sleeper before to one behind
    both[: places + 1, :4], both[: places + 1, 6 : 6 + m] = own[:, :4], own[:, 4:]
    both[places:, 2:6], both[places:, 6 + m :] = own[:, :4], own[:, 4:]
    reach = round(PATCH / dx)
    s = np.arange(-reach, reach + 1) / (reach + 1)
    weights = 7 * s**4 - 10 * s**2 + 3
    weights /= weights.sum()
    averaged = np.stack([np.convolve(column, weights, "same") for column in both.T], axis=1)
    around = slice(places - places // 2, places - places // 2 + places)
    uniform = track_line(replace(line.track, line=SupportLine(bays=COLUMNS)))
    nodes = (np.arange(3)[:, None] * uniform.size + np.arange(2)).ravel()
    units = np.zeros((uniform.size * COLUMNS, 6))
    units[nodes, range(6)] = 1.0
    compliance = splu(uniform.matrices()[2]).solve(units)[nodes]
    inside = np.abs(np.arange(places) - places // 2) * dx

    def static(rows: Real) -> Real:
        return np.asarray(np.einsum("pi,ij,pj->p", rows[:, :6], compliance, rows[:, :6]))

    exact = static(both[around]) + local_flexibility(line.track.rail, spacing, inside, inside)
    modal = (averaged[around, 6:] ** 2 / np.tile(span.modes, 2)).sum(axis=1)
    return np.ascontiguousarray(averaged[around]), exact - static(averaged[around]) - modal


def _highest(line: TrackLine, inertia: Real) -> float:
    """Square of the highest frequency, rad^2/s^2, of bays with the stiffest supports of the line everywhere."""
    everywhere = np.ones((4, 2))
    bays = replace(
        line,
        pad_stiffness=everywhere * line.pad_stiffness.max(),
        pad_damping=everywhere,
        ballast_stiffness=everywhere * line.ballast_stiffness.max(),
        ballast_damping=everywhere,
        gap=everywhere * np.nan,
    )
    M, _, K = (matrix.toarray() for matrix in bays.matrices())
    rows = (np.arange(4)[:, None] * line.size + 4 + np.arange(2 * len(inertia))).ravel()
    M[rows, rows] += np.tile(inertia - 1.0, 8)
    return float(eigh(K, M, eigvals_only=True, subset_by_index=(len(K) - 1, len(K) - 1))[0])


class _Sleepers(NamedTuple):
    """Fields of ``LineSteps`` that follow from sleepers and pads; rows of factors up to SOLVE."""

    factors: Real
    loss: Real  # (bays, 2, 2) kg, p_r e_r.S_s^-1 e_j p_j, by which sleepers that give way lower the inertia of nodes
    shapes: Real
    states: Real
    hanging: NDArray[np.int64]
    hang: Real


def _sleepers(line: TrackLine, implicit: float, dt: float) -> _Sleepers:
    """Sleepers with pads and ballast in pairs of states; ``implicit`` is kappa, s^2."""
    bays, s, seats = line.bays, len(line.sleeper.stiffness), line.sleeper.seats
    holds = np.isnan(line.gap)
    hanging = np.where(holds.all(axis=1), -1, np.cumsum(~holds.all(axis=1)) - 1)
    factors = np.zeros((SOLVE, bays))
    pads = implicit * line.pad_stiffness + dt / 2 * line.pad_damping  # (bays, 2)
    factors[STIFF : STIFF + 2], factors[DAMP : DAMP + 2] = line.pad_stiffness.T, line.pad_damping.T
    factors[IMPLICIT : IMPLICIT + 2] = pads.T
    factors[DIRECT], factors[DIRECT + 3] = 1.0, 1.0
    if s == 0:
        none = np.zeros((bays, 0, 0))
        return _Sleepers(factors, np.zeros((bays, 2, 2)), none, none, np.full(bays, -1), np.zeros((0, STATES + 2, 0)))
    K = np.einsum("bh,hij->bij", line.ballast_stiffness * holds, line.sleeper.ballast)
    K += np.diag(line.sleeper.stiffness) + np.einsum("bh,hi,hj->bij", line.pad_stiffness, seats, seats)
    C = np.einsum("bh,hij->bij", line.ballast_damping * holds, line.sleeper.ballast)
    C += np.einsum("bh,hi,hj->bij", line.pad_damping, seats, seats)
    inverse = np.linalg.inv(np.eye(s) + dt / 2 * C + implicit * K)
    direct = pads[:, :, None] * (seats @ inverse @ seats.T)
    reach = pads[:, :, None] * (seats @ inverse)
    factors[DIRECT : DIRECT + 4] -= direct.reshape(bays, 4).T

    Q, P = dt**2 * inverse @ K, dt * inverse @ C
    change = np.block([[-Q, np.eye(s) - P], [-Q, -P]])
    poles, shapes = _pairs(change)
    states: Real = np.asarray(np.linalg.inv(shapes), dtype=np.float64)
    at_once = dt**2 * np.concatenate([inverse, inverse], axis=1)  # (bays, 2 s, s)
    gains = states @ at_once @ seats.T
    u, v = np.split(shapes, 2, axis=1)
    outputs = np.einsum("bh,hi,bij->bhj", line.pad_stiffness, seats, u)
    outputs += np.einsum("bh,hi,bij->bhj", line.pad_damping, seats, v) / dt
    outputs -= reach @ (K @ u + C @ v / dt)
    factors[FACTOR:GAIN] = poles.reshape(bays, -1).T
    factors[GAIN:OUTPUT] = gains.reshape(bays, -1).T
    factors[OUTPUT:SOLVE] = outputs.transpose(0, 2, 1).reshape(bays, -1).T
    hung = hanging >= 0
    hang = np.concatenate([states[hung] @ at_once[hung], reach[hung]], axis=1)
    return _Sleepers(factors, direct * pads[:, None, :], shapes, states, hanging, hang)


def _pairs(change: Real) -> tuple[Real, Real]:
    """Eigenvalues less 1 of steps ``x <- x + change x``, (bays, n, n), in pairs, and the real basis that parts them.

    Returns alpha - 1, alpha' - 1 and beta of each pair, (bays, n / 2, 3), and the basis (bays, n, n).
    """
    values, vectors = (np.asarray(each, dtype=np.complex128) for each in np.linalg.eig(change))
    order = np.argsort(values.imag == 0.0, axis=1, kind="stable")  # conjugates, which are neighbours, before real ones
    values = np.take_along_axis(values, order, axis=1)
    vectors = np.take_along_axis(vectors, order[:, None, :], axis=2)
    turns = values[:, ::2].imag
    shapes = vectors.real.copy()
    shapes[:, :, 1::2] = np.where(turns[:, None, :] != 0.0, -vectors[:, :, ::2].imag, shapes[:, :, 1::2])
    return np.stack([values[:, ::2].real, values[:, 1::2].real, turns], axis=2), shapes


def _chain(line: TrackLine, inertia: Real, implicit: float, half: float, loss: Real) -> tuple[Real, Real, Real]:
    """SOLVE of nodes behind the wheels and ahead, ``LineSteps.chain`` and ``middle``.

    ``implicit`` s^2 and ``half`` s weigh stiffness and damping.
    """
    span, bays = line.span, line.bays
    pads = implicit * line.pad_stiffness + half * line.pad_damping  # (bays, 2)
    ends = span.mass + implicit * span.stiffness - span.coupling / inertia @ span.coupling.T
    nodes: Real = np.zeros((bays, 4, 4))
    nodes[:] = np.kron(np.eye(2), ends[:2, :2] + ends[2:, 2:])
    turn = line.track.pad.length**2 / 12.0
    nodes[:, range(4), range(4)] += np.repeat(pads, 2, axis=1) * np.array([1.0, turn, 1.0, turn])
    nodes[:, ::2, ::2] -= loss
    link: Real = np.asarray(np.kron(np.eye(2), ends[:2, 2:]), dtype=np.float64)

    left = _carried(nodes, link)
    right = tuple(part[::-1] for part in _carried(nodes[::-1], link.T))
    solve = np.concatenate([side[0].reshape(bays, 16).T for side in (left, right)])
    carry = np.stack([left[1], right[1]])
    chain = np.concatenate([each.reshape(2, bays, 16) for each in (carry, carry.swapaxes(2, 3))], axis=2)
    middle = np.zeros((bays, 3, 4, 3, 4))
    for node in range(3):
        middle[:, node, :, node] = np.roll(nodes, 1 - node, axis=0)
    middle[:, 0, :, 0] -= np.roll(left[2], 2, axis=0)
    middle[:, 2, :, 2] -= np.roll(right[2], -2, axis=0)
    middle[:, 0, :, 1] = middle[:, 1, :, 2] = link
    middle[:, 1, :, 0] = middle[:, 2, :, 1] = link.T
    return solve, chain, np.asarray(np.linalg.inv(middle.reshape(bays, 12, 12)), dtype=np.float64)


def _carried(nodes: Real, link: Real) -> tuple[Real, Real, Real]:
    """Along a closed chain of ``nodes`` (bays, 4, 4): inverse of what is left of each, what it carries, and takes."""
    solve, carry, taken = (np.empty_like(nodes) for _ in range(3))
    before = np.zeros((4, 4))
    for bay in range(-CONVERGED, len(nodes)):
        solve[bay] = np.linalg.inv(nodes[bay] - before)
        carry[bay] = solve[bay] @ link
        before = taken[bay] = link.T @ carry[bay]
    return solve, carry, taken
