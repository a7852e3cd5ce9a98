"""Kalker's variational method for the normal contact: the active set of Eqs (8) to (12).

Problem. Before they deform, the surfaces of the elements I are g_I apart. Find the pressures p at an approach delta::

    d_I = g_I + sum_J A_IJ p_J - (delta - c0 F)                              Eqs (10), (12)
    p_I >= 0,   d_I >= 0,   p_I d_I = 0                                      Eq. (8)
    F = s sum_I p_I                                                          Eq. (11)

    d      m                      distance of the deformed surfaces
    g      m     ``separation``   z_R + z_W + r_R + r_W of Eq. (12)
    delta  m     ``approach``     -(xi_R + xi_W) of Eq. (12), without what the force of this step displaces
    c0     m/N   ``compliance``   what the force of this step adds to xi_R + xi_W, per newton
    A      m/Pa  ``influence``    half-spaces, by element offset (``influence.influence_table``)
    s      m^2   ``element_area``
    F      N     ``force``

Eq. (8) is the condition for the minimum of s (p.A p / 2 + p.(g - delta)) + c0 F^2 / 2 over p >= 0. A is positive
definite, so there is exactly one solution. No entry of A is negative, so d_I >= g_I - (delta - c0 F). Only the m
elements with g_I < delta can be in contact: the candidates. Under smooth surfaces about half of them are.

Mirror images. Where g is symmetric about the middle column, the elements from that column on carry the problem. Each
has a weight w_I: 2, or 1 in the middle column; without symmetry w = 1. A unit pressure on J and on its image acts with
w_J ``pair(I, J)``, the weighted mean of both influences. Row I times w_I gives the symmetric K_IJ = w_I w_J pair(I, J).

One set. Let S be the elements in contact: d = 0 on S, p = 0 elsewhere. With K = U^T U on S, y = U^-T w (delta - g)
and h = U^-T w (``load`` and ``punch``: U^-1 h is the pressure of a flat punch per unit of approach)::

    U p = y - c0 F h,   F = s h.y / (1 + c0 s h.h),   dF/d delta = s h.h / (1 + c0 s h.h).

The second follows from F = s w.p, the third from dy/d delta = h.

Exchange. Elements of S with p < 0 leave, all others with d < 0 enter, both at once; then S is solved again. This is the
primal-dual active set method (M. Hintermueller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2002) 865-888).

Termination. It holds for matrices whose inverse M has no positive entry off its diagonal, a non-negative M^-1 and
positive row sums. A of half-spaces has such an inverse (``tests/contact/test_influence.py``); so has the block of any
subset, K, and A + c0 s 1 1^T. Let e be the new distances minus the old ones, with M d = p - M (delta - g)::

    on the new S:            d_new = 0, and d_old <= 0, for only overlap lets an element in:  e >= 0
    on the new rest N:       p_new = 0, and p_old <= 0, for only suction lets one out:        (M e)_N = -p_old >= 0
    hence                    M_NN e_N = -p_old - M_NS e_S >= 0,   e_N >= 0.

So distances never fall from one set to the next, and equal distances mean a solution: no set comes again. After the
first exchange no distance is negative, so from then on elements only leave. Whatever the first guess, at most m + 2
sets are solved; two to seven are on the contacts tested. Rounding and other matrices could break the argument. So after
SIMULTANEOUS sets elements enter only when none leaves (Kalker's order), and after MOST_ITERATIONS the search ends.

Tolerances. Suction up to ``RELATIVE_TOLERANCE (delta - min g) / A_00`` and overlap up to RELATIVE_TOLERANCE
(delta - min g) count as none. Eq. (8) holds to 1e-13 m (``tests/contact/test_active_set.py``).

Cost. A set of n elements takes n^3/6 multiply-adds for U and n^2/2 + n (m - n) influence coefficients.

Neglected: the bodies are half-spaces of one material without friction, and their surfaces are parallel to the track
plane. The grid of 1 mm by 0.75 mm gives the force of Hertz within 0.2 % from 20 kN on (``law.ELEMENT_WIDTH``).

Source: J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), Chapter 4. The elimination of the
compliance and the proof of termination are derived here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import kernel

CONVERGED = 0
NOT_CONVERGED = 1
AT_BORDER = 2
NOT_FINITE = 3

SIMULTANEOUS = 20
MOST_ITERATIONS = 200
RELATIVE_TOLERANCE = 1e-11


class Candidates(NamedTuple):
    """The m elements that can be in contact, in the order of their positions."""

    i: NDArray[np.int64]
    """Index along x, (m,)."""
    j: NDArray[np.int64]
    """Index along y, (m,)."""
    gap: Real
    """Separation g, (m,), m."""
    weight: Real
    """w: 2 for an element that stands for its mirror image too, else 1, (m,)."""


@kernel
def pair(influence: Real, mirrored: bool, centre: int, i: int, j: int, I: int, J: int) -> float:  # noqa: E741
    """Displacement at element (i, j) for unit pressure on (I, J), m/Pa.

    With ``mirrored`` it is the mean for (I, J) and for its image about the column ``centre``.
    """
    direct: float = influence[abs(i - I), abs(j - J)]
    if mirrored:
        image: float = influence[abs(i - I), j + J - 2 * centre]
        return 0.5 * (direct + image)
    return direct


@kernel
def at_border(nx: int, ny: int, mirrored: bool, i: int, j: int) -> bool:
    """Whether element (i, j) lies at the border of the potential contact area."""
    return i == 0 or i == nx - 1 or j == ny - 1 or (j == 0 and not mirrored)


@kernel
def cholesky(K: Real) -> bool:
    """Factor K = U^T U in place, upper triangle (n, n); False if K is not positive definite.

    Four rows are eliminated at a time, so each sweep over the rest of K makes four updates for one load and store.
    """
    n = len(K)
    for k in range(0, n, 4):
        last = min(k + 4, n)
        for row in range(k, last):
            target = K[row, row:]
            for done in range(k, row):
                factor = K[done, row]
                source = K[done, row:]
                for j in range(len(target)):
                    target[j] -= factor * source[j]
            if not target[0] > 0.0:
                return False
            scale = 1.0 / np.sqrt(target[0])
            for j in range(len(target)):
                target[j] *= scale
        for i in range(last, n):
            f0, f1, f2, f3 = K[k, i], K[k + 1, i], K[k + 2, i], K[k + 3, i]
            r0, r1, r2, r3 = K[k, i:], K[k + 1, i:], K[k + 2, i:], K[k + 3, i:]
            target = K[i, i:]
            for j in range(len(target)):
                target[j] -= f0 * r0[j] + f1 * r1[j] + f2 * r2[j] + f3 * r3[j]
    return True


@kernel
def forward(U: Real, b: Real) -> None:
    """Solve U^T y = b in place; U (n, n), b (n,)."""
    for k in range(len(b)):
        b[k] /= U[k, k]
        row = U[k, k + 1 :]
        rest = b[k + 1 :]
        for j in range(len(rest)):
            rest[j] -= b[k] * row[j]


@kernel
def backward(U: Real, y: Real) -> None:
    """Solve U x = y in place; U (n, n), y (n,)."""
    n = len(y)
    for k in range(n - 1, -1, -1):
        even, odd = 0.0, 0.0
        for j in range(k + 1, n - 1, 2):
            even += U[k, j] * y[j]
            odd += U[k, j + 1] * y[j + 1]
        if (n - k) % 2 == 0:
            even += U[k, n - 1] * y[n - 1]
        y[k] = (y[k] - even - odd) / U[k, k]


@kernel
def candidates(separation: Real, mirrored: bool, approach: float) -> Candidates:
    """Elements whose separation is below ``approach``, m; with ``mirrored`` from the middle column on."""
    nx, ny = separation.shape
    first = ny // 2 if mirrored else 0
    count = 0
    for i in range(nx):
        for j in range(first, ny):
            count += separation[i, j] < approach
    at_i, at_j, gap, weight = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count), np.ones(count)
    count = 0
    for i in range(nx):
        for j in range(first, ny):
            if separation[i, j] < approach:
                at_i[count], at_j[count], gap[count] = i, j, separation[i, j]
                if mirrored and j != first:
                    weight[count] = 2.0
                count += 1
    return Candidates(at_i, at_j, gap, weight)


@kernel
def first_set(c: Candidates, edge: float, in_contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Candidates in the first set, (m,): those of ``in_contact`` (nx, ny), or all up to ``edge``, m, if it has none."""
    m = len(c.gap)
    active = np.empty(m, np.bool_)
    occupied = False
    for a in range(m):
        active[a] = in_contact[c.i[a], c.j[a]]
        occupied |= active[a]
    if not occupied:
        for a in range(m):
            active[a] = c.gap[a] <= edge
    return active


@kernel
def solve_set(
    c: Candidates,
    chosen: NDArray[np.int64],
    mirrored: bool,
    centre: int,
    influence: Real,
    element_area: float,
    approach: float,
    compliance: float,
    p: Real,
) -> tuple[float, float, bool]:
    """Force, N, and stiffness, N/m, of the set of ``chosen`` (n,) candidates; False if K is not positive definite.

    Fills the pressures ``p`` (n,), Pa.
    """
    n, (at_i, at_j, gap, weight) = len(chosen), c
    K = np.empty((n, n))
    punch = np.empty(n)
    for a in range(n):
        I = chosen[a]  # noqa: E741
        punch[a] = weight[I]
        p[a] = weight[I] * (approach - gap[I])
        for b in range(a, n):
            J = chosen[b]
            K[a, b] = weight[I] * weight[J] * pair(influence, mirrored, centre, at_i[I], at_j[I], at_i[J], at_j[J])
    if not cholesky(K):
        return np.nan, np.nan, False
    forward(K, p)
    forward(K, punch)
    force, stiffness = 0.0, 0.0
    for a in range(n):
        force += punch[a] * p[a]
        stiffness += punch[a] * punch[a]
    relief = 1.0 + compliance * element_area * stiffness
    force = element_area * force / relief
    for a in range(n):
        p[a] -= compliance * force * punch[a]
    backward(K, p)
    return force, element_area * stiffness / relief, True


@kernel
def exchange(
    c: Candidates,
    chosen: NDArray[np.int64],
    p: Real,
    mirrored: bool,
    centre: int,
    influence: Real,
    local: float,
    tolerance: float,
    simultaneous: bool,
    active: NDArray[np.bool_],
) -> int:
    """Let elements that pull out of contact and elements that overlap into it; returns how many.

    Parameters
    ----------
    c
        Candidates.
    chosen, p
        Candidates in contact and their pressures, both (n,), Pa.
    mirrored, centre, influence
        As in ``pair``.
    local
        Approach at the contact, delta - c0 F, m.
    tolerance
        Overlap that counts as none, m.
    simultaneous
        Whether elements enter although others leave.
    active
        Whether each candidate is in contact, (m,); changed in place.
    """
    n, removed, added = len(chosen), 0, 0
    at_i, at_j, gap, weight = c
    for a in range(n):
        if p[a] * influence[0, 0] < -tolerance:
            active[chosen[a]] = False
            removed += 1
    if removed > 0 and not simultaneous:
        return removed
    present = np.zeros(len(gap), np.bool_)
    for a in range(n):
        present[chosen[a]] = True
    for I in range(len(gap)):  # noqa: E741
        if present[I]:
            continue
        distance = gap[I] - local
        for b in range(n):
            J = chosen[b]
            distance += weight[J] * p[b] * pair(influence, mirrored, centre, at_i[I], at_j[I], at_i[J], at_j[J])
        if distance < -tolerance:
            active[I] = True
            added += 1
    return removed + added


@kernel
def record(
    c: Candidates,
    chosen: NDArray[np.int64],
    p: Real,
    mirrored: bool,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> bool:
    """Write a solution into ``in_contact`` and ``pressure``; returns whether an element of it lies at the border."""
    nx, ny = in_contact.shape
    border = False
    for a in range(len(chosen)):
        i, j = c.i[chosen[a]], c.j[chosen[a]]
        image = 2 * (ny // 2) - j if mirrored else j
        border |= at_border(nx, ny, mirrored, i, j)
        in_contact[i, j] = in_contact[i, image] = True
        if pressure.size:
            pressure[i, j] = pressure[i, image] = max(p[a], 0.0)
    return border


@kernel
def solve_active_set(
    separation: Real,
    mirrored: bool,
    influence: Real,
    element_area: float,
    approach: float,
    compliance: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Solve the contact of one geometry at one approach.

    Parameters
    ----------
    separation
        Undeformed separation g of the elements, irregularities included, (nx, ny), m.
    mirrored
        Whether ``separation`` is symmetric about the middle column; ny is odd then.
    influence
        Influence coefficients A by element offset, (nx, ny) or larger, m/Pa.
    element_area
        s, m^2.
    approach
        delta, m.
    compliance
        c0, m/N.
    in_contact
        First guess of the elements in contact, (nx, ny); left with the solution, or all False without one. The guess
        decides how many sets are solved, not the solution: the last set is factored in the order of positions.
    pressure
        Filled with the pressures, (nx, ny), Pa. Pass an empty (0, 0) array if you need the force alone.

    Returns
    -------
    force
        F, N; 0 without contact, NaN unless the status is CONVERGED.
    stiffness
        dF/d delta, N/m, likewise.
    status
        CONVERGED, NOT_CONVERGED (no solution within MOST_ITERATIONS), AT_BORDER (the contact reaches the border of the
        area) or NOT_FINITE (an input is no number, or the influence matrix is not positive definite).
    """
    nx, ny = separation.shape
    if not np.isfinite(approach) or not compliance >= 0.0:
        return np.nan, np.nan, NOT_FINITE
    c = candidates(separation, mirrored, approach)
    if pressure.size:
        pressure[:] = 0.0
    m = len(c.gap)
    if m == 0:
        in_contact[:] = False
        return 0.0, 0.0, CONVERGED
    lowest = c.gap[0]
    for a in range(m):  # a loop: reductions of NumPy take seconds to compile
        lowest = min(lowest, c.gap[a])
    # Hertz: at the edge of the contact of two spheres the undeformed separation is half the approach.
    edge = 0.5 * (lowest + approach)
    for a in range(m):
        if c.gap[a] <= edge and at_border(nx, ny, mirrored, c.i[a], c.j[a]):
            # Far too deep for the area: solving for thousands of elements would only confirm it.
            in_contact[:] = False
            return np.nan, np.nan, AT_BORDER
    active = first_set(c, edge, in_contact)
    in_contact[:] = False
    centre, tolerance = ny // 2, RELATIVE_TOLERANCE * (approach - lowest)
    for iteration in range(MOST_ITERATIONS):
        chosen = np.nonzero(active)[0]
        p = np.empty(len(chosen))
        force, stiffness, definite = solve_set(
            c, chosen, mirrored, centre, influence, element_area, approach, compliance, p
        )
        if not definite:
            return np.nan, np.nan, NOT_FINITE
        local, both = approach - compliance * force, iteration < SIMULTANEOUS
        if exchange(c, chosen, p, mirrored, centre, influence, local, tolerance, both, active) == 0:
            if not np.isfinite(force):
                return np.nan, np.nan, NOT_FINITE
            if record(c, chosen, p, mirrored, in_contact, pressure):
                in_contact[:] = False
                return np.nan, np.nan, AT_BORDER
            return force, stiffness, CONVERGED
    return np.nan, np.nan, NOT_CONVERGED
