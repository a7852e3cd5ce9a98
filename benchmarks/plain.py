"""The plain reference: the method as the paper reads, in NumPy, without one thought of speed.

Every step convolves the whole history of the forces with the Green's functions, Eqs (4) to (7) and (16), and solves
both contacts by Kalker's active set, whose equations are set up and solved anew for every guess of the contact area.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.contact.law_kernels import ContactLaw, total_separation

Real = NDArray[np.float64]


class Plain:
    """Goes on from where ``dynamics`` of the package's ``paper`` implementation, the tables' source, has come to."""

    def __init__(self, dynamics: Any, law: ContactLaw, preload: Real, tread_origin: int, step: int) -> None:
        self.green, self.law, self.preload = dynamics, law, preload
        self.tread_origin, self.step = tread_origin, step
        done = int(dynamics.done[0])
        self.past = [row[row.size - done :].copy() for row in dynamics.past]  # F - P, the newest first

    def advance(self) -> tuple[Real, Real]:
        """Contact forces (2,) N and stress components (S,) Pa of the next step."""
        g, steps = self.green, len(self.past[0])
        ago = np.arange(1, steps + 1)
        wheel = np.array([sum(G[1 : steps + 1] @ F for G, F in zip(row, self.past, strict=True)) for row in g.wheel])
        on_rail = ago[: g.direct.shape[1] - 1]
        hit = (self.step - on_rail) % len(g.direct)  # the place at which each of the past forces hit the rail
        direct, cross = g.direct[hit, on_rail], g.cross[hit, on_rail]
        one, two = (F[: len(on_rail)] for F in self.past)
        rail = np.array([direct @ one + cross @ two, direct @ two + cross @ one])
        place = self.step % len(g.direct)
        xi = g.wheel_static + wheel + g.rail_static[place] + rail

        tread = self.step - self.tread_origin
        forces = np.empty(2)
        for w in range(2):
            gap = total_separation(self.law, w, tread, self.step)
            forces[w] = normal_contact(gap, self.law, self.preload[w] - xi[w], g.rail_compliance[place])
        stress = g.stress_static + [
            sum(G[1 : steps + 1] @ F for G, F in zip(row, self.past, strict=True)) for row in g.stress
        ]
        self.past = [np.concatenate([[force - g.load], F]) for force, F in zip(forces, self.past, strict=True)]
        self.step += 1
        return forces, stress


def normal_contact(gap: Real, law: ContactLaw, approach: float, compliance: float) -> float:
    """Force, N, by Kalker's variational method, Eqs (8) to (12); ``compliance`` times it is lost from the approach."""
    i, j = np.nonzero(gap < approach)
    A = law.influence[abs(i[:, None] - i), abs(j[:, None] - j)]
    overlap = approach - gap[i, j]
    active = np.ones(len(i), bool)
    while active.any():
        p, q = np.linalg.solve(A[np.ix_(active, active)], np.stack([overlap[active], np.ones(active.sum())], 1)).T
        force = law.element_area * p.sum() / (1 + compliance * law.element_area * q.sum())
        pressure = np.zeros(len(i))
        pressure[active] = p - compliance * force * q
        if (pressure < 0).any():
            active &= pressure >= 0
            continue
        enter = ~active & (overlap - compliance * force - A @ pressure > 1e-11 * overlap.max())
        if not enter.any():
            return float(force)
        active |= enter
    return 0.0
