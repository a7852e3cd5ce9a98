"""Kalker's variational method with an upper bound on the pressure: an elastic, perfectly plastic contact.

Problem. ``active_set_kernels`` states the elastic contact and has the symbols. With a hardness H, Pa, find p at delta::

    d_I = g_I + sum_J A_IJ p_J - (delta - c0 F)
    p_I = 0 and d_I >= 0,   or   0 <= p_I <= H and d_I = 0,   or   p_I = H and d_I <= 0
    F = s sum_I p_I

An element either is apart, or bears elastically, or has yielded. Where it has yielded the bodies would still overlap by
-d_I, which is the depth of the plastic indentation. These are the conditions for the minimum of
s (p.A p / 2 + p.(g - delta)) + c0 F^2 / 2 over 0 <= p <= H. A is positive definite, so there is exactly one solution.

Yielded elements as a load. Let Y be the yielded elements. They bear s H |Y| and displace the others like any given
pressure. What is left is an elastic contact of the elements beside Y::

    g'_I   = g_I + H sum_(J in Y) A_IJ     (infinite on Y)
    delta' = delta - c0 s H |Y|
    F      = s H |Y| + F',    dF/d delta = dF'/d delta'

so ``solve_active_set`` solves it as it is.

Exchange. Y is empty at first: that is the elastic contact. All elements with p > H join Y, and the contact beside Y is
solved again, until no pressure is above H.

Termination. Let M = (A + c0 s 1 1^T)^-1, which has no positive entry off its diagonal (``active_set_kernels``), and e
the new distances minus the old ones of one exchange. With M d = p - M (delta - g)::

    joined Y, or were in it:   p_new = H <= p_old                                (M e) <= 0
    apart afterwards:          p_new = 0 <= p_old                                (M e) <= 0
    bear elastically:          d_new = 0, and d_old >= 0 outside Y:                 e  <= 0

On the first two sets C, M_CC e_C <= -M_CE e_E <= 0 with the third set E, so e_C <= 0: no distance rises. An element of
Y had d = 0 when it joined, so d <= 0 ever after: Y need not give elements back. Y only grows; with m elements there are
at most m exchanges. Three to eight are on the contacts tested. At the end the three conditions hold: on Y d <= 0, on
the rest Eq. (8) and p <= H.

Monotony. By the same argument F rises with delta and falls with H, and a contact holds all elements of the elastic one.
F is at most H times the area in contact.

Repeatability. The elastic solution does not depend on the first guess (``active_set_kernels``), and all that follows is
a function of it: equal inputs give equal bits.

Tolerance. Pressures up to H (1 + RELATIVE_TOLERANCE) count as elastic.

Neglected: the plastic deformation is not kept. Each step is the answer to the first loading of the present geometry;
treads and rails are not reshaped by what went before. The bound is the same everywhere, and does not rise with strain.

Source: the bound on the pressure is a usual extension of the variational method, e.g. K. L. Johnson, Contact Mechanics
(1985), Section 6.3, for its value, and A. Almqvist, F. Sahlin, R. Larsson, S. Glavatskih, Tribology International 40
(2007) 574-579 for the bounded problem. The sequence of elastic contacts and the proof are derived here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import kernel
from .active_set_kernels import CONVERGED, NOT_CONVERGED, RELATIVE_TOLERANCE, solve_active_set


@kernel
def exceeds(pressure: Real, hardness: float) -> bool:
    """Whether a pressure (nx, ny), Pa, is above the hardness, Pa."""
    most = hardness * (1.0 + RELATIVE_TOLERANCE)
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            if pressure[i, j] > most:
                return True
    return False


@kernel
def let_yield(
    pressure: Real,
    hardness: float,
    mirrored: bool,
    influence: Real,
    approach: float,
    gap: Real,
    yielded: NDArray[np.bool_],
) -> int:
    """Let all elements above the hardness yield; returns how many.

    Parameters
    ----------
    pressure
        Of the contact beside those that have yielded, (nx, ny), Pa.
    hardness
        H, Pa.
    mirrored, influence
        As in ``solve_active_set``.
    approach
        delta, m: elements whose gap is above it are out of reach.
    gap
        g', (nx, ny), m; changed in place, with ``mirrored`` from the middle column on only.
    yielded
        Y, (nx, ny); changed in place.
    """
    nx, ny = gap.shape
    most, joined = hardness * (1.0 + RELATIVE_TOLERANCE), 0
    at_i, at_j = np.empty(nx * ny, np.int64), np.empty(nx * ny, np.int64)
    for i in range(nx):
        for j in range(ny):
            if pressure[i, j] > most:
                yielded[i, j] = True
                gap[i, j] = np.inf
                at_i[joined], at_j[joined] = i, j
                joined += 1
    for i in range(nx):
        for j in range(ny // 2 if mirrored else 0, ny):
            if gap[i, j] < approach:
                total = 0.0
                for a in range(joined):
                    total += influence[abs(i - at_i[a]), abs(j - at_j[a])]
                gap[i, j] += hardness * total
    return joined


@kernel
def solve_yielding(
    separation: Real,
    mirrored: bool,
    influence: Real,
    element_area: float,
    approach: float,
    compliance: float,
    hardness: float,
    in_contact: NDArray[np.bool_],
    pressure: Real,
) -> tuple[float, float, int]:
    """Solve the contact of one geometry at one approach with pressures up to a hardness.

    Parameters
    ----------
    separation, mirrored, influence, element_area, approach, compliance
        As in ``solve_active_set``.
    hardness
        H, Pa.
    in_contact
        Elements of the elastic contact, (nx, ny); left with those in contact, or all False without a solution.
    pressure
        Pressures of the elastic contact, (nx, ny), Pa; left with the solution.

    Returns
    -------
    force, stiffness, status
        As of ``solve_active_set``.
    """
    nx, ny = separation.shape
    gap, yielded = separation.copy(), np.zeros((nx, ny), np.bool_)
    held, bears = 0.0, in_contact.copy()
    for _ in range(nx * ny + 1):
        held += hardness * element_area * let_yield(pressure, hardness, mirrored, influence, approach, gap, yielded)
        local = approach - compliance * held
        force, stiffness, status = solve_active_set(
            gap, mirrored, influence, element_area, local, compliance, bears, pressure
        )
        if status != CONVERGED:
            in_contact[:] = False
            return np.nan, np.nan, status
        if not exceeds(pressure, hardness):
            for i in range(nx):
                for j in range(ny):
                    pressure[i, j] = hardness if yielded[i, j] else min(pressure[i, j], hardness)
                    in_contact[i, j] = bears[i, j] or yielded[i, j]
            return held + force, stiffness, CONVERGED
    in_contact[:] = False
    return np.nan, np.nan, NOT_CONVERGED
