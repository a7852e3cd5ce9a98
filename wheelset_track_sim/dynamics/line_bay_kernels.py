"""Bays of the ``line`` dynamics side by side: one Newmark step, solved along the chain of sleepers.

Problem. The unknowns of the bays around the wheels obey, with the matrices of ``track.line.TrackLine.matrices``::

    M u'' + C u' + K u = f(t)

    u   m, rad, sqrt(kg) m       deflections, rotations, modes of mass 1; v and a are their rates
    f   N, N m, N / sqrt(kg)     loads of the wheels, of hanging sleepers and of the dampers at both ends
    dt  s                        step

Step: Newmark's with gamma = 1/2 and beta = 1/12, also known as Fox and Goodwin's::

    u* = u + dt v + 5/12 dt^2 a,     v* = v + dt/2 a
    S a' = f - C v* - K u*,          S = M + dt/2 C + kappa K,    kappa = (1/12 + alpha) dt^2
    u' = u* + dt^2/12 a',            v' = v* + dt/2 a'

The state that is stored is the predictor u*, v* of the coming step. The lines above advance it by::

    v* <- v* + dt a',    u* <- u* + dt v*

Without damping and with alpha = 0, a mode of frequency omega turns by theta a step. With W = omega dt,
cos theta = 1 - W^2 / (2 + W^2 / 6). So theta = W (1 + W^4 / 480 + ...): the amplitude is kept, and the period is too
short by W^4 / 480, which is 2e-4 at 2.5 kHz and 100 km/h. The step is stable up to W^2 = 6, with any damping in C.
``line_steps`` chooses alpha, and the inertia m_i of the rail's modes, so that the highest frequency stays below that.
Statics do not depend on either.

Hanging sleepers and end dampers act through u* and v* alone, not through S. A damper c on the inertia m is then stable
while c dt < 2 m; ``line.line_model`` and ``line_steps.END_LOSS`` keep to that.

Condensation. Only the rails join bays, so S is solved in stages. First the modes of the rail between nodes b and b + 1,
with e_i = omega_i^2 / m_i u*_i, are condensed into both nodes::

    m_i a_i + c_i.[a_b, a_b+1] = -omega_i^2 u*_i       so      a_i = -e_i - c_i.[a_b, a_b+1] / m_i

A span is symmetric about its middle: its modes are symmetric or antisymmetric in turn, and couple to w_b + w_b+1 and
theta_b - theta_b+1, or to w_b - w_b+1 and theta_b + theta_b+1. Its stiffness splits in the same way.

A sleeper on its ballast, with both pads, has the modal deflections u_s and the matrices K_s, C_s and S_s. e_r is its
deflection at the seat of rail r. The pad of rail r, with stiffness k_r and damping c_r, gets g_r from the rail::

    g_r = k_r w_r + c_r w_r' = g*_r + p_r a_w,r        p_r = kappa k_r + dt/2 c_r       g*_r with w*_r, w'*_r
    S_s a_s = e_1 g_1 + e_2 g_2 - C_s v*_s - K_s u*_s

So x = [u*_s, dt v*_s] advances by a fixed matrix of the bay, x <- A x + B g. With a basis T of its eigenvectors, r =
T^-1 x falls into ten pairs of real states that advance alone (``line_steps`` derives A, B, T)::

    [r, q] <- [[alpha, -beta], [beta, alpha']] [r, q] + G [g_1, g_2]      alpha = alpha' or beta = 0      (FACTOR, GAIN)
    back_r = o_r.r                                                        what the sleeper's motion pushes back (OUTPUT)
    load on w_r: back_r - sum_j E_rj g*_j                                 E = 1 - p_r e_r.S_s^-1 e_j            (DIRECT)

It is the same step, in 12 multiply-adds a pair instead of 40 a mode.

A chain of nodes remains, N_b a_b + T a_b+1 + T^T a_b-1 = g_b. The chain is eliminated from both ends towards the three
nodes around the wheels. Behind them::

    P_b = N_b - T^T P_b-1^-1 T,    g_b+1 <- g_b+1 - (P_b^-1 T)^T g_b        ``sweep``; P_b^-1 (SOLVE), P_b^-1 T (chain)
    a_b = P_b^-1 g_b - P_b^-1 T a_b+1                                       ``spread``

and ahead of them the same with T^T for T. The middle three are solved with their inverse (``line_kernels``). P_b is
worked out for a line without ends. P^-1 T has eigenvalues up to 0.06, so P_b depends on some eight nodes.

Around the wheels a step with whole matrices gives the same accelerations to 1e-9
(``tests/dynamics/test_line_kernels.py``). Cost: 48 columns times some 300 multiply-adds a step, whatever the length of
the line.

Memory. Each unknown has a row of ``COLUMNS`` numbers, one for each bay, and all rows are one array, ``motion``. The
distances in memory are then known to the compiler, as in ``causal_kernels``; with several arrays it would give up to
prove that they do not overlap. The wheels are within half a bay of the column ``MIDDLE``. What a loop needs of the next
column it would have to load off the border of a register, so spans store what they do to their far end one column on.

Sources: N. M. Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94; L. Fox and E. T. Goodwin, Math. Proc. Cambridge Phil.
Soc. 45 (1949) 373-388. The condensation and the sleeper's pairs are derived here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.jit import bare_kernel

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

STATES = 4 * HALF
"""Numbers of a sleeper's state."""

RAIL = 4 + 2 * RAIL_MODES
"""Unknowns of both rails in a bay: deflection and rotation of rail 1 and 2 above a sleeper, then the modes of rail 1
and of rail 2 up to the next sleeper."""

U, V = 0, RAIL
R = V + RAIL
BACK = R + STATES
KEPT = BACK + 2
A = KEPT
LOAD = A + 4
PAD = LOAD + 4
SPAN = PAD + 2
BEFORE = SPAN + 8
ROWS = BEFORE + STATES
"""First rows of the parts of ``Bays.motion``, and their number.

U, V: u* and v* of the rails. R: states of the sleepers. BACK: what their motion pushes back on rail 1 and 2, N. Rows up
to KEPT are the state, and move on with the wheels. A: accelerations of the nodes. LOAD: loads on the nodes. PAD: g*.
SPAN: load of a span on its near node, and one column on that on its far node: w and theta each, of rail 1, then of
rail 2. BEFORE: states of the sleepers before the step at which the speed changes.
"""

STIFF, DAMP, IMPLICIT, DIRECT = 0, 2, 4, 6
FACTOR = DIRECT + 4
GAIN = FACTOR + 3 * HALF * 2
OUTPUT = GAIN + 2 * STATES
SOLVE = OUTPUT + 2 * STATES
FACTORS = SOLVE + 16
"""First rows of the parts of ``LineSteps.factors``, and their number.

STIFF and DAMP: k and c of the pads of rail 1 and 2. IMPLICIT: p of both. DIRECT: E. FACTOR: alpha - 1, alpha' - 1 and
beta of each pair. GAIN: G of each pair, r by g_1 and g_2, q by g_1 and g_2. OUTPUT: o of each pair, r on rail 1 and 2,
q on rail 1 and 2. SOLVE: P^-1 of nodes behind the wheels; the same for nodes ahead follows after FACTORS.
"""


class LineParts(NamedTuple):
    """What is the same in all bays and at all speeds."""

    bend: float  # N m/rad of a span against theta_b - theta_b+1, on both ends
    shear: np.ndarray  # (3,) of a span against w_b - w_b+1 (N/m), both (N/rad), theta_b + theta_b+1 (N m/rad)
    coupling: np.ndarray  # (2, RAIL_MODES) c: mass between w and theta of the near end and the modes
    nodes: np.ndarray  # (2 HALF, nodes) deflection of the sleeper's nodes in its modes; none on slab track
    shares: np.ndarray  # (2, nodes) of the ballast under the half of rail 1 and 2 that acts on each node
    turn: float  # m^2, rotational over vertical stiffness of a pad, and damping likewise
    losses: np.ndarray  # (2 COLUMNS,) N s/m, then N m s: end dampers of deflection and rotation
    shapes: np.ndarray  # (L, 6 + 2 RAIL_MODES) shapes of three nodes and of the modes behind and ahead, at L places


@bare_kernel
def load_spans(parts: LineParts, squared: np.ndarray, motion: np.ndarray) -> None:
    """Fill the rows SPAN with what each span does to its ends, its modes condensed.

    ``squared`` is omega_i^2 / m_i, (RAIL_MODES,), 1/s^2.
    """
    n, m, c = COLUMNS, motion, parts.coupling
    q0, q1, q2, q3 = squared[0], squared[1], squared[2], squared[3]
    w0, w1, w2, w3 = c[0, 0], c[0, 1], c[0, 2], c[0, 3]
    t0, t1, t2, t3 = c[1, 0], c[1, 1], c[1, 2], c[1, 3]
    bend, k_w, k_wt, k_t = parts.bend, parts.shear[0], parts.shear[1], parts.shear[2]
    for rail in range(2):
        w, t, mode, span = (U + 2 * rail) * n, (U + 2 * rail + 1) * n, (U + 4 + 4 * rail) * n, (SPAN + 4 * rail) * n
        for b in range(NODES - 1):
            across, turned = m[w + b] - m[w + b + 1], m[t + b] + m[t + b + 1]
            e0, e1 = q0 * m[mode + b], q1 * m[mode + n + b]
            e2, e3 = q2 * m[mode + 2 * n + b], q3 * m[mode + 3 * n + b]
            even_w = w0 * e0 + w2 * e2
            even_t = t0 * e0 + t2 * e2 - bend * (m[t + b] - m[t + b + 1])
            odd_w = w1 * e1 + w3 * e3 - k_w * across - k_wt * turned
            odd_t = t1 * e1 + t3 * e3 - k_wt * across - k_t * turned
            m[span + b], m[span + n + b] = even_w + odd_w, even_t + odd_t
            m[span + 2 * n + b + 1], m[span + 3 * n + b + 1] = even_w - odd_w, odd_t - even_t


@bare_kernel
def load_nodes(parts: LineParts, window: np.ndarray, motion: np.ndarray) -> None:
    """Fill the rows LOAD, and PAD with g*: spans on both sides, pads, sleepers and end dampers on the nodes.

    ``window`` are the factors of the bays at hand, (FACTORS COLUMNS,).
    """
    n, m, f, turn, losses = COLUMNS, motion, window, parts.turn, parts.losses
    s, e = SPAN * n, DIRECT * n
    for b in range(n):
        w1, t1, w2, t2 = b, n + b, 2 * n + b, 3 * n + b
        v1, r1, v2, r2 = m[V * n + w1], m[V * n + t1], m[V * n + w2], m[V * n + t2]
        k1, k2, c1, c2 = f[STIFF * n + b], f[(STIFF + 1) * n + b], f[DAMP * n + b], f[(DAMP + 1) * n + b]
        lost, turned = losses[b], losses[n + b]
        g1, g2 = k1 * m[w1] + c1 * v1, k2 * m[w2] + c2 * v2
        m[PAD * n + b], m[(PAD + 1) * n + b] = g1, g2
        on1 = m[BACK * n + b] - f[e + b] * g1 - f[e + n + b] * g2
        on2 = m[(BACK + 1) * n + b] - f[e + 2 * n + b] * g1 - f[e + 3 * n + b] * g2
        m[LOAD * n + w1] = on1 - lost * v1 + m[s + b] + m[s + 2 * n + b]
        m[LOAD * n + w2] = on2 - lost * v2 + m[s + 4 * n + b] + m[s + 6 * n + b]
        about1 = turn * (k1 * m[t1] + c1 * r1) + turned * r1
        about2 = turn * (k2 * m[t2] + c2 * r2) + turned * r2
        m[LOAD * n + t1] = m[s + n + b] + m[s + 3 * n + b] - about1
        m[LOAD * n + t2] = m[s + 5 * n + b] + m[s + 7 * n + b] - about2


@bare_kernel
def sweep(chain: np.ndarray, motion: np.ndarray) -> None:
    """Condense the loads g of all nodes into the three in the middle, from both ends at the same time.

    ``chain`` holds P^-1 T of each node, then its transpose, (COLUMNS, 32).
    """
    n, m, load = COLUMNS, motion, LOAD * COLUMNS
    end = load + NODES - 1
    g0, g1, g2, g3 = m[load], m[load + n], m[load + 2 * n], m[load + 3 * n]
    h0, h1, h2, h3 = m[end], m[end + n], m[end + 2 * n], m[end + 3 * n]
    for away in range(MIDDLE - 1):
        c, d, b, e = chain[away], chain[NODES - 1 - away], load + away + 1, end - away - 1
        x0 = m[b] - c[0] * g0 - c[4] * g1 - c[8] * g2 - c[12] * g3
        x1 = m[b + n] - c[1] * g0 - c[5] * g1 - c[9] * g2 - c[13] * g3
        x2 = m[b + 2 * n] - c[2] * g0 - c[6] * g1 - c[10] * g2 - c[14] * g3
        x3 = m[b + 3 * n] - c[3] * g0 - c[7] * g1 - c[11] * g2 - c[15] * g3
        y0 = m[e] - d[0] * h0 - d[4] * h1 - d[8] * h2 - d[12] * h3
        y1 = m[e + n] - d[1] * h0 - d[5] * h1 - d[9] * h2 - d[13] * h3
        y2 = m[e + 2 * n] - d[2] * h0 - d[6] * h1 - d[10] * h2 - d[14] * h3
        y3 = m[e + 3 * n] - d[3] * h0 - d[7] * h1 - d[11] * h2 - d[15] * h3
        m[b], m[b + n], m[b + 2 * n], m[b + 3 * n] = x0, x1, x2, x3
        m[e], m[e + n], m[e + 2 * n], m[e + 3 * n] = y0, y1, y2, y3
        g0, g1, g2, g3, h0, h1, h2, h3 = x0, x1, x2, x3, y0, y1, y2, y3


@bare_kernel
def spread(window: np.ndarray, chain: np.ndarray, motion: np.ndarray) -> None:
    """Fill the rows A for all nodes from the three in the middle, towards both ends at the same time.

    Rows LOAD are replaced by P^-1 g.
    """
    n, m, load, s = COLUMNS, motion, LOAD * COLUMNS, SOLVE * COLUMNS
    for b in range(n):
        g0, g1, g2, g3 = m[load + b], m[load + n + b], m[load + 2 * n + b], m[load + 3 * n + b]
        for i in range(4):
            p = s + 4 * i * n + b
            m[load + i * n + b] = window[p] * g0 + window[p + n] * g1 + window[p + 2 * n] * g2 + window[p + 3 * n] * g3
    near, far = A * n + MIDDLE - 1, A * n + MIDDLE + 1
    shift = (A - LOAD) * n
    x0, x1, x2, x3 = m[near], m[near + n], m[near + 2 * n], m[near + 3 * n]
    y0, y1, y2, y3 = m[far], m[far + n], m[far + 2 * n], m[far + 3 * n]
    for away in range(1, MIDDLE):
        c, d, b, e = chain[MIDDLE - 1 - away], chain[MIDDLE + 1 + away], near - away, far + away
        p0 = m[b - shift] - c[16] * x0 - c[20] * x1 - c[24] * x2 - c[28] * x3
        p1 = m[b - shift + n] - c[17] * x0 - c[21] * x1 - c[25] * x2 - c[29] * x3
        p2 = m[b - shift + 2 * n] - c[18] * x0 - c[22] * x1 - c[26] * x2 - c[30] * x3
        p3 = m[b - shift + 3 * n] - c[19] * x0 - c[23] * x1 - c[27] * x2 - c[31] * x3
        q0 = m[e - shift] - d[16] * y0 - d[20] * y1 - d[24] * y2 - d[28] * y3
        q1 = m[e - shift + n] - d[17] * y0 - d[21] * y1 - d[25] * y2 - d[29] * y3
        q2 = m[e - shift + 2 * n] - d[18] * y0 - d[22] * y1 - d[26] * y2 - d[30] * y3
        q3 = m[e - shift + 3 * n] - d[19] * y0 - d[23] * y1 - d[27] * y2 - d[31] * y3
        m[b], m[b + n], m[b + 2 * n], m[b + 3 * n] = p0, p1, p2, p3
        m[e], m[e + n], m[e + 2 * n], m[e + 3 * n] = q0, q1, q2, q3
        x0, x1, x2, x3, y0, y1, y2, y3 = p0, p1, p2, p3, q0, q1, q2, q3


@bare_kernel
def advance_rails(
    parts: LineParts, squared: np.ndarray, inertia: np.ndarray, dt: float, next_dt: float, motion: np.ndarray
) -> None:
    """Advance u* and v* of nodes and rail modes by their accelerations, those of the modes from those of the nodes.

    After a step of ``dt`` comes one of ``next_dt`` s: v* grows by (dt + dt_next) / 2 a and u* by dt_next v* and
    (dt^2/12 + dt dt_next/2 + 5/12 dt_next^2) a.
    """
    n, m, c = COLUMNS, motion, parts.coupling
    faster, farther = (dt + next_dt) / 2.0, dt * dt / 12.0 + dt * next_dt / 2.0 + next_dt * next_dt * (5.0 / 12.0)
    rate = (V - U) * n
    for rail in range(2):
        w, t, on = (A + 2 * rail) * n, (A + 2 * rail + 1) * n, (U + 4 + 4 * rail) * n
        for pair in range(2):
            i = 2 * pair
            w0, t0, w1, t1 = c[0, i] / inertia[i], c[1, i] / inertia[i], c[0, i + 1], c[1, i + 1]
            w1, t1 = w1 / inertia[i + 1], t1 / inertia[i + 1]
            q0, q1, even, odd = squared[i], squared[i + 1], on + i * n, on + (i + 1) * n
            for b in range(NODES - 1):
                x, y = even + b, odd + b
                e = -q0 * m[x] - w0 * (m[w + b] + m[w + b + 1]) - t0 * (m[t + b] - m[t + b + 1])
                o = -q1 * m[y] - w1 * (m[w + b] - m[w + b + 1]) - t1 * (m[t + b] + m[t + b + 1])
                m[x] += next_dt * m[x + rate] + farther * e
                m[y] += next_dt * m[y + rate] + farther * o
                m[x + rate] += faster * e
                m[y + rate] += faster * o
    for row in range(4):
        x, a = (U + row) * n, (A + row) * n
        for b in range(n):
            m[x + b] += next_dt * m[x + rate + b] + farther * m[a + b]
            m[x + rate + b] += faster * m[a + b]


@bare_kernel
def advance_sleepers(window: np.ndarray, motion: np.ndarray) -> None:
    """Advance the states R of the sleepers by a step, and fill BACK with what they push back at the next one."""
    n, m, f = COLUMNS, motion, window
    for b in range(n):
        m[PAD * n + b] += f[IMPLICIT * n + b] * m[A * n + b]
        m[(PAD + 1) * n + b] += f[(IMPLICIT + 1) * n + b] * m[(A + 2) * n + b]
        m[BACK * n + b] = m[(BACK + 1) * n + b] = 0.0
    for pair in range(2 * HALF):
        r, q = (R + 2 * pair) * n, (R + 2 * pair + 1) * n
        a, g, o = (FACTOR + 3 * pair) * n, (GAIN + 4 * pair) * n, (OUTPUT + 4 * pair) * n
        for b in range(n):
            g1, g2, x, y = m[PAD * n + b], m[(PAD + 1) * n + b], m[r + b], m[q + b]
            x_next = x + f[a + b] * x - f[a + 2 * n + b] * y + f[g + b] * g1 + f[g + n + b] * g2
            y_next = y + f[a + n + b] * y + f[a + 2 * n + b] * x + f[g + 2 * n + b] * g1 + f[g + 3 * n + b] * g2
            m[r + b], m[q + b] = x_next, y_next
            m[BACK * n + b] += f[o + b] * x_next + f[o + 2 * n + b] * y_next
            m[(BACK + 1) * n + b] += f[o + n + b] * x_next + f[o + 3 * n + b] * y_next
