"""The force-approach curve of one geometry, exactly.

With a fixed set of elements in contact the pressures are linear in the approach, so the force of the discretised
contact is piecewise linear, with a kink where an element enters. Following the approach from first touch and adding
one element at a time gives all kinks, and the table is the solution itself, not an interpolation of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.jit import kernel
from .active_set_kernels import at_border, pair

BLOCK = 64


@kernel
def enlarged(array: Real, rows: int, columns: int) -> Real:
    """Copy of an array in the corner of a larger one."""
    larger = np.zeros((rows, columns))
    for i in range(array.shape[0]):  # assigning a slice takes seconds to compile
        for j in range(array.shape[1]):
            larger[i, j] = array[i, j]
    return larger


@kernel
def follow_path(
    at_i: NDArray[np.int64],
    at_j: NDArray[np.int64],
    gap: Real,
    shape: tuple[int, int],
    mirrored: bool,
    influence: Real,
    element_area: float,
    largest_force: float,
) -> Real:
    """Kinks of the force-approach curve as in ``tables.force_path``.

    ``gap``, m, rises: the separation of the elements at ``at_i``, ``at_j`` of an area of a ``shape``; with
    ``mirrored`` of those from its middle column on.

    Between kinks the pressures p grow by q times the approach, where q is that of a flat punch on the elements in
    contact. The inverse of their influence matrix is carried along and bordered or deflated by one element a kink;
    ``felt`` holds what unit pressure on each of them does to all elements.
    """
    nx, ny = shape
    centre = ny // 2
    m = len(gap)
    weight = np.ones(m)
    if mirrored:
        for c in range(m):
            if at_j[c] != centre:
                weight[c] = 2.0

    points = np.empty((4 * m + 4, 2))
    approach, force = gap[0], 0.0
    points[0, 0], points[0, 1] = approach, force
    count = 1
    inside = np.zeros(m, np.bool_)
    chosen = np.empty(m, np.int64)
    inverse, felt = np.zeros((64, 64)), np.zeros((64, m))
    p, q, column, g = np.zeros(m), np.zeros(m), np.empty(m), np.empty(m)
    distance, closing = np.empty(BLOCK), np.empty(BLOCK)
    n = 0
    entering, leaving = 0, -1
    # Every kink adds or removes an element; the bound only ends a path that cannot advance.
    for _ in range(4 * m):
        if entering >= 0:
            i, j = at_i[entering], at_j[entering]
            if at_border(nx, ny, mirrored, i, j):
                break
            if n == len(inverse):
                inverse, felt = enlarged(inverse, 2 * n, 2 * n), enlarged(felt, 2 * n, m)
            for c in range(m):
                felt[n, c] = weight[entering] * pair(influence, mirrored, centre, at_i[c], at_j[c], i, j)
            own = weight[entering] * felt[n, entering]
            rate = weight[entering]
            for a in range(n):
                g[a] = 0.0
            for b in range(n):
                column[b] = weight[entering] * felt[b, entering]
                row = inverse[b, :n]
                for a in range(n):
                    g[a] += column[b] * row[a]
            for b in range(n):
                own -= column[b] * g[b]
                rate -= column[b] * q[b]
            rate /= own
            for b in range(n):
                q[b] -= rate * g[b]
                scaled = g[b] / own
                row = inverse[b, :n]
                for a in range(n):
                    row[a] += scaled * g[a]
                inverse[b, n] = -scaled
                inverse[n, b] = -scaled
            inverse[n, n] = 1.0 / own
            q[n], p[n] = rate, 0.0
            chosen[n] = entering
            inside[entering] = True
            n += 1
        elif leaving >= 0:
            n -= 1
            inside[chosen[leaving]] = False
            for a in range(n + 1):
                g[a] = inverse[leaving, a]
            g[leaving], g[n] = g[n], g[leaving]
            # The last element takes the place of the one that leaves.
            for a in range(n + 1):
                inverse[leaving, a] = inverse[n, a]
            for a in range(n + 1):
                inverse[a, leaving] = inverse[a, n]
            inverse[leaving, leaving] = inverse[n, n]
            chosen[leaving], p[leaving] = chosen[n], p[n]
            for c in range(m):
                felt[leaving, c] = felt[n, c]
            q[leaving], q[n] = q[n], q[leaving]
            for b in range(n):
                q[b] -= g[b] * q[n] / g[n]
                for a in range(n):
                    inverse[b, a] -= g[b] * g[a] / g[n]

        slope = 0.0
        for b in range(n):
            slope += element_area * weight[chosen[b]] * q[b]
        following = approach + (largest_force - force) / slope
        entering, leaving = -1, -1
        for b in range(n):
            if q[b] < 0.0 and approach - p[b] / q[b] < following:
                following = approach - p[b] / q[b]
                leaving = b
        for start in range(0, m, BLOCK):
            if gap[start] >= following:
                break
            end = min(start + BLOCK, m)
            for c in range(end - start):
                distance[c], closing[c] = gap[start + c] - approach, 1.0
            for b in range(n):
                row = felt[b, start:end]
                for c in range(len(row)):
                    distance[c] += p[b] * row[c]
                    closing[c] -= q[b] * row[c]
            for c in range(end - start):
                if not inside[start + c] and closing[c] > 0.0:
                    meeting = approach + max(distance[c], 0.0) / closing[c]
                    if meeting < following:
                        following = meeting
                        entering, leaving = start + c, -1
        advance = max(following - approach, 0.0)
        for b in range(n):
            p[b] += advance * q[b]
        approach += advance
        force += advance * slope
        # Elements that enter together (mirror images) make one kink.
        if count > 1 and approach - points[count - 1, 0] <= 1e-12 * (approach - gap[0]):
            count -= 1
        if approach > points[0, 0]:
            points[count, 0], points[count, 1] = approach, force
            count += 1
        if entering < 0 and leaving < 0:
            break
    return points[:count].copy()
