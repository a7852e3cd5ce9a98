"""Loops around the kernels of the coupled step, so that each can be timed alone."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from wheelset_track_sim.contact.law_kernels import contact_force, tabulated_force
from wheelset_track_sim.dynamics import interface_kernels

kernel = numba.njit(nogil=True, error_model="numpy")
summing = numba.njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


@kernel
def forces(law: Any, approach: np.ndarray, found: np.ndarray) -> None:
    """``contact_force`` of wheel 1 at one place after the other."""
    for i in range(len(approach)):
        found[i] = contact_force(law, 0, i, i, approach[i], 0.0)


@kernel
def displacements(dynamics: Any, forces: np.ndarray, xi: np.ndarray) -> None:
    """What modes displace, step by step."""
    for i in range(len(forces)):
        interface_kernels.displacements(dynamics, i, xi[i])


@kernel
def advance(dynamics: Any, forces: np.ndarray) -> None:
    """Modes of wheelset and track moved on, step by step."""
    for i in range(len(forces)):
        interface_kernels.advance(dynamics, i, forces[i])


@kernel
def stresses(dynamics: Any, forces: np.ndarray, stress: np.ndarray) -> None:
    """Stress sums, step by step."""
    for i in range(len(forces)):
        interface_kernels.stresses(dynamics, forces[i], stress[i])


@kernel
def look_ups(law: Any, tread: int, approach: np.ndarray, found: np.ndarray) -> None:
    """Both contacts from their tables; the approach (n, 2) is that of a run, so that branches are its own."""
    for i in range(len(approach)):
        for wheel in range(2):
            found[i, wheel] = tabulated_force(law, wheel, (tread + i) % law.table.shape[1], 0, approach[i, wheel], 0.0)


@summing
def repeated_total(x: np.ndarray, repeats: int) -> float:
    """Sum of an array, again and again: as fast as it can be loaded."""
    found = 0.0
    for _ in range(repeats):
        part = 0.0
        for i in range(len(x)):
            part += x[i]
        x[0] = part  # so that no sum can be left out
        found += part
    return found
