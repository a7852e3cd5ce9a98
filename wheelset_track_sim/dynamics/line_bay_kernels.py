"""Bays of the ``line`` dynamics side by side: one Newmark step, solved along the chain of sleepers.

Problem. The unknowns of the bays around the wheels obey, with the matrices of ``track.line.TrackLine.matrices``::

    M u'' + C u' + K u = f(t)

    u   m, rad, sqrt(kg) m       ``deflection``: deflections, rotations, modes of mass 1; v and a are their rates
    f   N, N m, N / sqrt(kg)     loads of the wheels, of hanging sleepers and of the dampers at both ends
    dt  s                        step

Step: Newmark's with gamma = 1/2 and beta = 1/12, also known as Fox and Goodwin's::

    u* = u + dt v + 5/12 dt^2 a,     v* = v + dt/2 a                                              ``predict``
    S a' = f - C v* - K u*,          S = M + dt/2 C + kappa K,    kappa = (1/12 + alpha) dt^2
    u' = u* + dt^2/12 a',            v' = v* + dt/2 a'                                            ``correct``

Without damping and with alpha = 0, a mode of frequency omega turns by theta a step. With W = omega dt,
cos theta = 1 - W^2 / (2 + W^2 / 6). So theta = W (1 + W^4 / 480 + ...): the amplitude is kept, and the period is too
short by W^4 / 480, which is 2e-4 at 2.5 kHz and 100 km/h. The step is stable up to W^2 = 6, with any damping in C.
``line_steps`` chooses alpha, and the inertia m_i of the rail's modes, so that the highest frequency stays below that.
Statics do not depend on either.

Hanging sleepers and end dampers act through u* and v* alone, not through S. A damper c on the inertia m is then stable
while c dt < 2 m; ``line.line_model`` and ``line_steps.END_LOSS`` keep to that.

Condensation. Only the rails join bays, so S is solved in stages. e_r is the deflection of the sleeper's modes at the
seat of rail r. k_r and c_r are stiffness and damping of the pad of rail r; K_r and C_r belong to the ballast under its
half of the sleeper, which acts on the modes with the matrix B_r::

    rail modes    m_i a_i + c_i.[a_b, a_b+1] = f_i          between nodes b and b + 1; a_b of w, theta of both rails
    sleeper       S_s a_s - sum_r p_r e_r a_w,r = f_s       p_r = kappa k_r + dt/2 c_r
                  S_s = 1 + kappa Lambda + sum_r (kappa K_r + dt/2 C_r) B_r + sum_r p_r e_r e_r^T
    so            a_i = (f_i - c_i.[a_b, a_b+1]) / m_i
                  a_s = S_s^-1 f_s + sum_r h_r a_w,r        h_r = S_s^-1 p_r e_r (REACH), S_s^-1 (INVERSE)

A chain of nodes remains, N_b a_b + T a_b+1 + T^T a_b-1 = g_b. Its loads are the nodes' own, less c_i f_i / m_i of all
modes i of the spans on both sides, plus h_r.f_s on the deflection of rail r (``load_rails``). The chain is eliminated
from both ends towards the three nodes around the wheels. Behind them::

    P_b = N_b - T^T P_b-1^-1 T,    g_b+1 <- g_b+1 - (P_b^-1 T)^T g_b        ``sweep``; P_b^-1 (SOLVE), P_b^-1 T (CARRY)
    a_b = P_b^-1 g_b - P_b^-1 T a_b+1                                       ``spread``

and ahead of them the same with T^T for T. The middle three are solved with their inverse (``line_kernels``). P_b is
worked out for a line without ends. P^-1 T has eigenvalues up to 0.06, so P_b depends on some eight nodes.

Around the wheels a step with whole matrices gives the same accelerations to 1e-9
(``tests/dynamics/test_line_kernels.py``). Cost: 48 columns times some 600 multiply-adds a step, whatever the length of
the line.

Memory. Each unknown has a row of ``COLUMNS`` numbers, one for each bay, and all rows are one array. The distances in
memory are then known to the compiler, as in ``causal_kernels``. Rows: deflection and rotation of rail 1 and of rail 2
above a sleeper; the modes of rail 1 and of rail 2 up to the next sleeper; the modes of the sleeper, symmetric ones
first. The wheels are within half a bay of the column ``MIDDLE``.

Sources: N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; L. Fox and E. T. Goodwin, Math. Proc. Cambridge Phil.
Soc. 45 (1949) 373-388. The condensation is derived here.
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
"""Column of the sleeper nearest to the wheels."""

RAIL_MODES = 4
"""Modes of a rail between two sleepers."""

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
"""First rows of the parts of ``LineSteps.factors``, and their number.

PADS: stiffness of the pads of rail 1 and 2, N/m, then damping, N s/m. BEDS: ballast that holds both ways, sum and
difference of the stiffness under both halves, then of the damping. GAPS: gap of either side, m; NaN where the ballast
holds both ways. HUNG: ballast below gaps, stiffness of both sides, then damping. REACH: h_1 and h_2. INVERSE: S_s^-1.
SOLVE and CARRY: P^-1 and P^-1 T of nodes behind the wheels; the same for nodes ahead follows after FACTORS.
"""


class LineParts(NamedTuple):
    """What is the same in all bays and at all speeds."""

    stiffness: np.ndarray  # (4, 4) of a rail between two sleepers, of its ends [w, theta, w, theta]
    modes: np.ndarray  # (RAIL_MODES,) rad^2/s^2 of the rail's modes with held ends
    coupling: np.ndarray  # (4, RAIL_MODES) c: mass between ends and modes
    sleeper: np.ndarray  # (2 HALF,) Lambda, rad^2/s^2
    seat: np.ndarray  # (2 HALF,) e_1; e_2 has the other sign in antisymmetric modes
    ballast: np.ndarray  # (2 HALF, 2 HALF) B_1; B_2 has the other sign between modes of different symmetry
    nodes: np.ndarray  # (nodes, 2 HALF) deflection of the sleeper's nodes; none on slab track
    shares: np.ndarray  # (2, nodes) of the ballast under the half of rail 1 and 2 that acts on each node
    turn: float  # m^2, rotational over vertical stiffness of a pad, and damping likewise
    losses: np.ndarray  # (2 COLUMNS,) N s/m, then N m s: end dampers of deflection and rotation
    shapes: np.ndarray  # (L, 6 + 2 RAIL_MODES) shapes of three nodes and of the modes behind and ahead, at L places


@block_kernel
def predict(u: np.ndarray, v: np.ndarray, a: np.ndarray, dt: float) -> None:
    """Replace ``u`` and ``v``, (ROWS COLUMNS,), by u* and v* of the coming step of ``dt`` s."""
    ahead, half = dt * dt * (5.0 / 12.0), dt / 2.0
    for b in range(ROWS * COLUMNS):
        u[b] += dt * v[b] + ahead * a[b]
        v[b] += half * a[b]


@block_kernel
def load_pads(parts: LineParts, window: np.ndarray, u: np.ndarray, v: np.ndarray, load: np.ndarray) -> None:
    """Fill the rows of nodes of ``load`` with the loads of pads and end dampers on the rails of slab track.

    Parameters as in ``load_sleepers``.
    """
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
    """Fill the rows of nodes and sleepers of ``load`` with what pads, ballast, sleepers and end dampers do.

    The ballast under the two halves does k_1 B_1 + k_2 B_2 to the modes. B_1 and B_2 agree between modes of the same
    symmetry and differ in sign between others, so the former take k_1 + k_2 and the latter k_1 - k_2. Likewise the sum
    of both pads' forces acts on symmetric modes, their difference on antisymmetric ones.

    Parameters
    ----------
    parts, window
        Parts of the bays, and their rows of factors, (FACTORS COLUMNS,).
    u, v
        u* and v*, (ROWS COLUMNS,).
    load
        Filled, (ROWS COLUMNS,), N, N m, N / sqrt(kg).
    work
        Scratch, ((4 HALF + 4) COLUMNS,): k_1 + k_2, then k_1 - k_2, times each mode; deflection and rate at the seats.
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
    """Add the loads of the ballast under hanging sleepers: it pushes where the gap is closed, and never pulls.

    A node of the sleeper with the deflection u and the rate v is pushed with its share of k (u - gap) + c v where both
    u > gap and this force is positive. Parameters as in ``load_sleepers``.
    """
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
    """Complete the loads on both rails: stiffness of the rail, then modes and sleepers condensed into the nodes.

    Parameters
    ----------
    parts, window
        Parts of the bays, and their rows of factors, (FACTORS COLUMNS,).
    inertia
        m_i, (RAIL_MODES,).
    u
        u*, (ROWS COLUMNS,).
    load
        f on entry, g on the nodes on return, (ROWS COLUMNS,); rows of modes hold f_i and f_s.
    """
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
    """Condense the loads g of all nodes into the three in the middle, from both ends at the same time."""
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
    """Fill ``a`` for all nodes from the three in the middle, towards both ends at the same time."""
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
    """Fill ``a`` for the modes of rails and sleepers from the accelerations of the nodes.

    ``coupling`` is c, (4, RAIL_MODES), and ``push[1:]`` begins with the inertia m_i of the rail's modes.
    """
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
    """Add to u* and v* what the accelerations ``a`` of the step of ``dt`` s contribute, (ROWS COLUMNS,) each."""
    at_once, half = dt * dt / 12.0, dt / 2.0
    for b in range(ROWS * COLUMNS):
        u[b] += at_once * a[b]
        v[b] += half * a[b]
