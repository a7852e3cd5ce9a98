"""Bays of the ``line`` dynamics side by side: loads on their unknowns, and the accelerations that follow.

Unknowns stand in rows of ``COLUMNS`` numbers, one after the other in one array, and bays in columns, so that all
distances in memory are known to the compiler, as in ``causal_kernels``. Rows: deflection and rotation of rail 1 and of
rail 2 above a sleeper, the modes of rail 1 and of rail 2 up to the next sleeper, the modes of the sleeper, symmetric
ones first. The wheels are within half a bay of the column ``MIDDLE``. Deflections are ``u``, velocities ``v``,
accelerations ``a``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.jit import block_kernel

COLUMNS = 48
"""Columns in memory; the last is empty."""

NODES = 47
"""Sleepers that are followed."""

MIDDLE = 23

RAIL_MODES = 4
HALF = 5
"""Symmetric modes of a sleeper, and antisymmetric ones."""

SLEEPER = 4 + 2 * RAIL_MODES
"""Row of the first mode of a sleeper."""

ROWS = SLEEPER + 2 * HALF

PADS, BEDS, GAPS, HUNG, REACH = 0, 4, 8, 10, 14
INVERSE = REACH + 4 * HALF
SOLVE = INVERSE + 4 * HALF * HALF
CARRY = SOLVE + 16
FACTORS = CARRY + 16
"""First rows of ``LineSteps.factors``, and their number: stiffness of the pads of rail 1 and 2, damping; of ballast
that holds both ways sum and difference of stiffness, of damping; gaps of either side, NaN where it does; ballast below
gaps; what a rail's acceleration adds to a sleeper's modes; inverse of a sleeper's inertia; inverse of what is left of a
node's inertia, and what is carried from there towards the middle. The last two stand twice, for nodes behind and ahead
of the wheels."""


class LineParts(NamedTuple):
    """What is the same in all bays and at all speeds."""

    stiffness: np.ndarray  # (4, 4) of a rail's ends
    modes: np.ndarray  # (RAIL_MODES,) rad^2/s^2
    coupling: np.ndarray  # (4, RAIL_MODES) mass between ends and modes
    sleeper: np.ndarray  # (2 HALF,) rad^2/s^2
    seat: np.ndarray  # (2 HALF,) at rail 1; at rail 2 antisymmetric modes have the other sign
    ballast: np.ndarray  # (2 HALF, 2 HALF) of the half of rail 1; of rail 2 with the signs of both modes
    nodes: np.ndarray  # (nodes, 2 HALF) deflection of a sleeper's nodes; none on slab track
    shares: np.ndarray  # (2, nodes) of the ballast under the half of rail 1 and 2
    turn: float  # m^2 rotational over vertical stiffness of a pad
    losses: np.ndarray  # (2 COLUMNS,) N s/m, N m s: dampers of deflection and rotation towards both ends
    shapes: np.ndarray  # (L, 6 + 2 RAIL_MODES) three nodes, modes behind and ahead of the middle one, at a place


@block_kernel
def predict(u: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float) -> None:
    """Deflections and velocities of the coming step but for its accelerations."""
    ahead, half = dt * dt * (5.0 / 12.0), dt / 2.0
    for b in range(ROWS * COLUMNS):
        u[b] += dt * v[b] + ahead * a[b]
        v[b] += half * a[b]


@block_kernel
def load_pads(parts: LineParts, window: np.ndarray, u: np.ndarray, v: np.ndarray, load: np.ndarray) -> None:
    """Loads of the pads on the rails of slab track."""
    for rail in range(2):
        k, c, on = (PADS + rail) * COLUMNS, (PADS + 2 + rail) * COLUMNS, 2 * rail * COLUMNS
        for b in range(COLUMNS):
            w, t = on + b, on + COLUMNS + b
            lost, turned = parts.losses[b], parts.losses[COLUMNS + b]
            load[w] = -window[k + b] * u[w] - (window[c + b] + lost) * v[w]
            load[t] = -parts.turn * window[k + b] * u[t] - (parts.turn * window[c + b] + turned) * v[t]


@block_kernel
def load_sleepers(
    parts: LineParts, window: np.ndarray, u: np.ndarray, v: np.ndarray, load: np.ndarray, work: np.ndarray
) -> None:
    """Loads of pads and ballast on sleepers and rails.

    ``work`` takes sum and difference of what the two halves of the ballast do to each mode, then what both pads do.
    """
    n = COLUMNS
    for j in range(2 * HALF):
        p, total, difference = (SLEEPER + j) * n, j * n, (2 * HALF + j) * n
        for b in range(n):
            deflection, rate = u[p + b], v[p + b]
            work[total + b] = window[BEDS * n + b] * deflection + window[(BEDS + 2) * n + b] * rate
            work[difference + b] = window[(BEDS + 1) * n + b] * deflection + window[(BEDS + 3) * n + b] * rate
    seat, even, odd = parts.seat, 4 * HALF * n, (4 * HALF + 1) * n
    for side in range(2):
        s0, s1, s2, s3, s4 = (
            seat[5 * side],
            seat[5 * side + 1],
            seat[5 * side + 2],
            seat[5 * side + 3],
            seat[5 * side + 4],
        )
        p, at = (SLEEPER + HALF * side) * n, (4 * HALF + 2 * side) * n
        for b in range(n):
            i = p + b
            work[at + b] = s0 * u[i] + s1 * u[i + n] + s2 * u[i + 2 * n] + s3 * u[i + 3 * n] + s4 * u[i + 4 * n]
            work[at + n + b] = s0 * v[i] + s1 * v[i + n] + s2 * v[i + 2 * n] + s3 * v[i + 3 * n] + s4 * v[i + 4 * n]
    turn = parts.turn
    for b in range(n):
        sym, sym_rate, anti, anti_rate = (
            work[even + b],
            work[even + n + b],
            work[even + 2 * n + b],
            work[even + 3 * n + b],
        )
        k1, k2, c1, c2 = window[b], window[n + b], window[2 * n + b], window[3 * n + b]
        one = k1 * (u[b] - sym - anti) + c1 * (v[b] - sym_rate - anti_rate)
        two = k2 * (u[2 * n + b] - sym + anti) + c2 * (v[2 * n + b] - sym_rate + anti_rate)
        lost, turned = parts.losses[b], parts.losses[n + b]
        load[b] = -one - lost * v[b]
        load[n + b] = -turn * k1 * u[n + b] - (turn * c1 + turned) * v[n + b]
        load[2 * n + b] = -two - lost * v[2 * n + b]
        load[3 * n + b] = -turn * k2 * u[3 * n + b] - (turn * c2 + turned) * v[3 * n + b]
        work[even + b], work[odd + b] = one + two, one - two
    for i in range(2 * HALF):
        own, other = HALF * (i // HALF), HALF * (1 - i // HALF)
        c, d = parts.ballast[i, own : own + HALF], parts.ballast[i, other : other + HALF]
        c0, c1, c2, c3, c4 = c[0], c[1], c[2], c[3], c[4]
        d0, d1, d2, d3, d4 = d[0], d[1], d[2], d[3], d[4]
        on, pads, at_seat, squared = (SLEEPER + i) * n, even + i // HALF * n, seat[i], parts.sleeper[i]
        x, y = own * n, (2 * HALF + other) * n
        for b in range(n):
            load[on + b] = at_seat * work[pads + b] - squared * u[on + b]
        for b in range(n):
            j = x + b
            load[on + b] -= (
                c0 * work[j] + c1 * work[j + n] + c2 * work[j + 2 * n] + c3 * work[j + 3 * n] + c4 * work[j + 4 * n]
            )
        for b in range(n):
            j = y + b
            load[on + b] -= (
                d0 * work[j] + d1 * work[j + n] + d2 * work[j + 2 * n] + d3 * work[j + 3 * n] + d4 * work[j + 4 * n]
            )


@block_kernel
def load_hanging(parts: LineParts, window: np.ndarray, u: np.ndarray, v: np.ndarray, load: np.ndarray) -> None:
    """Ballast under hanging sleepers: it pushes where the gap is closed, and never pulls."""
    n = COLUMNS
    for side in range(2):
        for b in range(NODES):
            gap = window[(GAPS + side) * n + b]
            if np.isnan(gap):
                continue
            stiffness, damping = window[(HUNG + side) * n + b], window[(HUNG + 2 + side) * n + b]
            for node in range(parts.nodes.shape[0]):
                share, deflection, rate = parts.shares[side, node], 0.0, 0.0
                for j in range(2 * HALF):
                    deflection += parts.nodes[node, j] * u[(SLEEPER + j) * n + b]
                    rate += parts.nodes[node, j] * v[(SLEEPER + j) * n + b]
                push = share * (stiffness * (deflection - gap) + damping * rate)
                if deflection > gap and push > 0.0:
                    for j in range(2 * HALF):
                        load[(SLEEPER + j) * n + b] -= parts.nodes[node, j] * push


@block_kernel
def load_rails(parts: LineParts, inertia: np.ndarray, window: np.ndarray, u: np.ndarray, load: np.ndarray) -> None:
    """Loads on nodes and modes of both rails; modes and sleepers condensed into the nodes."""
    n, k, c = COLUMNS, parts.stiffness, parts.coupling
    for rail in range(2):
        w, t = 2 * rail * n, (2 * rail + 1) * n
        for end in range(2):
            w0, w1, w2, w3 = k[2 * end, 0], k[2 * end, 1], k[2 * end, 2], k[2 * end, 3]
            t0, t1, t2, t3 = k[2 * end + 1, 0], k[2 * end + 1, 1], k[2 * end + 1, 2], k[2 * end + 1, 3]
            for b in range(NODES - 1):
                i, j = w + b, t + b
                load[i + end] -= w0 * u[i] + w1 * u[j] + w2 * u[i + 1] + w3 * u[j + 1]
                load[j + end] -= t0 * u[i] + t1 * u[j] + t2 * u[i + 1] + t3 * u[j + 1]
        for i in range(RAIL_MODES):
            mode = (4 + RAIL_MODES * rail + i) * n
            squared = parts.modes[i]
            for b in range(NODES - 1):
                load[mode + b] = -squared * u[mode + b]
            for end in range(2):
                by_w, by_t = c[2 * end, i] / inertia[i], c[2 * end + 1, i] / inertia[i]
                for b in range(NODES - 1):
                    load[w + b + end] -= by_w * load[mode + b]
                    load[t + b + end] -= by_t * load[mode + b]
        for j in range(2 * HALF):
            mode, into = (SLEEPER + j) * n, (REACH + 2 * HALF * rail + j) * n
            for b in range(n):
                load[w + b] += window[into + b] * load[mode + b]


@block_kernel
def sweep(window: np.ndarray, load: np.ndarray) -> None:
    """Loads of all nodes condensed into the three in the middle, from both ends at a time."""
    n = COLUMNS
    for behind in range(MIDDLE - 1):
        ahead = NODES - 1 - behind
        for i in range(4):
            left = right = 0.0
            for j in range(4):
                left += window[(CARRY + 4 * j + i) * n + behind] * load[j * n + behind]
                right += window[(CARRY + 4 * j + i) * n + ahead] * load[j * n + ahead]
            load[i * n + behind + 1] -= left
            load[i * n + ahead - 1] -= right


@block_kernel
def spread(window: np.ndarray, load: np.ndarray, a: np.ndarray) -> None:
    """Accelerations of the nodes, from the middle to both ends."""
    n = COLUMNS
    for away in range(MIDDLE - 1):
        behind, ahead = MIDDLE - 2 - away, MIDDLE + 2 + away
        for i in range(4):
            left = right = 0.0
            for j in range(4):
                solve, carry = (SOLVE + 4 * i + j) * n, (CARRY + 4 * i + j) * n
                left += window[solve + behind] * load[j * n + behind] - window[carry + behind] * a[j * n + behind + 1]
                right += window[solve + ahead] * load[j * n + ahead] - window[carry + ahead] * a[j * n + ahead - 1]
            a[i * n + behind], a[i * n + ahead] = left, right


@block_kernel
def spread_in_bays(coupling: np.ndarray, push: np.ndarray, window: np.ndarray, load: np.ndarray, a: np.ndarray) -> None:
    """Accelerations of the modes of rails and sleepers."""
    n = COLUMNS
    for rail in range(2):
        w, t = 2 * rail * n, (2 * rail + 1) * n
        for i in range(RAIL_MODES):
            mode, inverse = (4 + RAIL_MODES * rail + i) * n, 1.0 / push[1 + i]
            c0, c1, c2, c3 = coupling[0, i], coupling[1, i], coupling[2, i], coupling[3, i]
            for b in range(NODES - 1):
                ends = c0 * a[w + b] + c1 * a[t + b] + c2 * a[w + b + 1] + c3 * a[t + b + 1]
                a[mode + b] = (load[mode + b] - ends) * inverse
    for i in range(2 * HALF):
        mode, one, two = (SLEEPER + i) * n, (REACH + i) * n, (REACH + 2 * HALF + i) * n
        for b in range(n):
            a[mode + b] = window[one + b] * a[b] + window[two + b] * a[2 * n + b]
        for half in range(2):
            first, on = (INVERSE + 2 * HALF * i + HALF * half) * n, (SLEEPER + HALF * half) * n
            for b in range(n):
                f, g = first + b, on + b
                a[mode + b] += (
                    window[f] * load[g]
                    + window[f + n] * load[g + n]
                    + window[f + 2 * n] * load[g + 2 * n]
                    + window[f + 3 * n] * load[g + 3 * n]
                    + window[f + 4 * n] * load[g + 4 * n]
                )


@block_kernel
def correct(u: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float) -> None:
    """What ``predict`` has left out."""
    at_once, half = dt * dt / 12.0, dt / 2.0
    for b in range(ROWS * COLUMNS):
        u[b] += at_once * a[b]
        v[b] += half * a[b]
