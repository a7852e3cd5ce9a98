"""A finite track in plain finite elements, every support its own: the independent model beside the line of bays.

Both rails and all sleepers are meshed as they are; nothing is reduced, no symmetry is used. Rail ends are clamped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from wheelset_track_sim.track.supports import Along
from wheelset_track_sim.track.timoshenko import element_matrices, local_flexibility, shape_functions
from wheelset_track_sim.track.track import Track

ELEMENTS = 16


class _Sum:
    """A sparse matrix, part by part."""

    def __init__(self, size: int) -> None:
        self.size, self.parts = size, []

    def add(self, at, values) -> None:
        rows, columns = np.meshgrid(at, at, indexing="ij")
        self.parts.append((np.broadcast_to(values, rows.shape).ravel(), rows.ravel(), columns.ravel()))

    def whole(self) -> sp.csr_array:
        values, rows, columns = (np.concatenate(part) for part in zip(*self.parts, strict=True))
        return sp.csr_array(sp.coo_array((values, (rows, columns)), shape=(self.size, self.size)))


@dataclass
class Elements:
    """Matrices of ``bays`` bays with sleepers in between; x = 0 is above the first sleeper that stands free."""

    track: Track
    supports: Along
    first: int
    bays: int

    def __post_init__(self) -> None:
        t, n = self.track, self.bays * ELEMENTS + 1
        self.rail_size, self.per_sleeper = 2 * n, 2 * (t.sleeper.elements + 1) if t.sleeper else 0
        size = 2 * self.rail_size + (self.bays + 1) * self.per_sleeper
        M, C, K = _Sum(size), _Sum(size), _Sum(size)
        k, m = element_matrices(t.rail, t.spacing / ELEMENTS)
        for rail in range(2):
            for element in range(n - 1):
                at = self.rail_size * rail + 2 * element + np.arange(4)
                K.add(at, k)
                M.add(at, m)
        self.hanging = []
        for index in range(self.bays + 1):
            bay = (self.first + index) % len(self.supports.gap)
            self._support(M, C, K, index, bay)
        ends = [
            self.rail_size * rail + end for rail in range(2) for end in (0, 1, self.rail_size - 2, self.rail_size - 1)
        ]
        self.free = np.setdiff1d(np.arange(size), ends)
        self.M, self.C, self.K = (sp.csc_array(A.whole()[self.free][:, self.free]) for A in (M, C, K))

    def _support(self, M: _Sum, C: _Sum, K: _Sum, index: int, bay: int) -> None:
        t, s = self.track, self.supports
        base = 2 * self.rail_size + index * self.per_sleeper
        if t.sleeper and t.ballast:
            count, length = t.sleeper.elements, t.sleeper.length / t.sleeper.elements
            k, m = element_matrices(t.sleeper, length)
            for element in range(count):
                at = base + 2 * element + np.arange(4)
                K.add(at, k)
                M.add(at, m)
            for node in range(count + 1):
                share = (0.5 if node in (0, count) else 1.0) / count
                for side in range(2):  # rail 1 is at the far end of the nodes
                    belongs = 0.5 if 2 * node == count else float((2 * node > count) == (side == 0))
                    stiffness = belongs * share * s.ballast_stiffness[bay, side] * t.ballast.stiffness
                    damping = belongs * share * s.ballast_damping[bay, side] * t.ballast.damping
                    one = base + 2 * node
                    if np.isnan(s.gap[bay, side]):
                        K.add([one], stiffness)
                        C.add([one], damping)
                    elif belongs:
                        self.hanging.append((one, s.gap[bay, side], stiffness, damping))
        for rail in range(2):
            w = self.rail_size * rail + 2 * ELEMENTS * index
            spring, damper = s.pad_stiffness[bay, rail] * t.pad.stiffness, s.pad_damping[bay, rail] * t.pad.damping
            columns, across = [w], [1.0]
            if t.sleeper:
                place = (t.sleeper.length / 2 + (0.5 - rail) * t.rail_distance) / (
                    t.sleeper.length / t.sleeper.elements
                )
                element = min(int(place + 1e-9), t.sleeper.elements - 1)
                shape = shape_functions(t.sleeper, length, np.array(place - element))[0]
                columns += list(base + 2 * element + np.arange(4))
                across += list(-shape)
            for matrix, value in ((K, spring), (C, damper)):
                matrix.add(columns, value * np.outer(across, across))
                matrix.add([w + 1], value * t.pad.length**2 / 12)

    def row(self, rail: int, x: float) -> np.ndarray:
        """Row of the free unknowns that gives the deflection of ``rail`` at ``x`` m of the line."""
        length = self.track.spacing / ELEMENTS
        place = x / length - self.first * ELEMENTS
        element = int(place + 1e-9)
        row = np.zeros(2 * self.rail_size + (self.bays + 1) * self.per_sleeper)
        row[self.rail_size * rail + 2 * element + np.arange(4)] = shape_functions(
            self.track.rail, length, np.array(place - element)
        )[0]
        return row[self.free]

    def inside(self, x: float) -> float:
        """Flexibility of a load inside its element, m/N."""
        length = self.track.spacing / ELEMENTS
        s = x % length
        return float(local_flexibility(self.track.rail, length, np.array(s), np.array(s)))

    def receptance(self, frequencies: np.ndarray, load: tuple[int, float], response: tuple[int, float]) -> np.ndarray:
        """Deflection at ``response`` (rail, x) for a unit force at ``load``; ballast with a gap is not there."""
        force, row = self.row(*load).astype(complex), self.row(*response)
        omega = 2 * np.pi * np.asarray(frequencies)
        dynamic = [sp.csc_array(self.K + 1j * w * self.C - w**2 * self.M) for w in omega]
        found = np.array([row @ splu(matrix).solve(force) for matrix in dynamic])
        return found + (self.inside(load[1]) if load == response else 0.0)

    def under_moving(self, forces: np.ndarray, start: float, dx: float, dt: float, finer: int) -> np.ndarray:
        """Deflections (steps, 2) of both rails under ``forces`` (steps, 2) that move by ``dx`` a step of ``dt``.

        Trapezoidal rule with ``finer`` steps a step, forces linear in between, from rest; ballast below gaps explicit.
        """
        h = dt / finer
        solve = splu(sp.csc_array(self.M + h / 2 * self.C + h**2 / 4 * self.K)).solve
        u = v = a = np.zeros(len(self.free))
        at = {full: free for free, full in enumerate(self.free)}
        hanging = [(at[node], gap, k, c) for node, gap, k, c in self.hanging]
        xi = np.zeros(forces.shape)
        for step in range(1, len(forces)):
            for part in range(1, finer + 1):
                share = part / finer
                x = start + (step - 1 + share) * dx
                force = (1 - share) * forces[step - 1] + share * forces[step]
                u, v = u + h * v + h**2 / 4 * a, v + h / 2 * a
                load = force[0] * self.row(0, x) + force[1] * self.row(1, x) - self.K @ u - self.C @ v
                for node, gap, k, c in hanging:
                    if u[node] > gap:
                        load[node] -= max(0.0, k * (u[node] - gap) + c * v[node])
                a = solve(load)
                u, v = u + h**2 / 4 * a, v + h / 2 * a
            x = start + step * dx
            xi[step] = [self.row(rail, x) @ u + self.inside(x) * forces[step, rail] for rail in range(2)]
        return xi
