"""Structured meshes of 8-node quadrilaterals in the half plane (y, r) of a body of revolution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real

RESOLUTION = 1e-9
"""Nodes nearer than this are one, m."""


@dataclass(frozen=True, eq=False)
class SectionMesh:
    """Nodes and elements of the section of a body of revolution."""

    points: Real
    """(nodes, 2): y and r, m."""
    elements: NDArray[np.int64]
    """(elements, 8): corners counter-clockwise in (y, r), then the nodes between corners 0-1, 1-2, 2-3, 3-0."""

    def nodes_on(self, points: Real) -> NDArray[np.int64]:
        """Nodes at given points (count, 2); raises ValueError if the mesh has none there."""
        distance = np.linalg.norm(self.points[None] - points[:, None], axis=2)
        found: NDArray[np.int64] = distance.argmin(axis=1)
        if (distance.min(axis=1) > 10 * RESOLUTION).any():
            raise ValueError(f"the mesh has no node at {points[distance.min(axis=1).argmax()]}")
        return found


def with_middles(corners: Sequence[float] | Real) -> Real:
    """Element corners with the middles between them: n + 1 values become 2 n + 1."""
    values = np.empty(2 * len(corners) - 1)
    values[::2] = corners
    values[1::2] = (values[:-2:2] + values[2::2]) / 2
    return values


def divided(breaks: Sequence[float], size: float) -> Real:
    """Nodes (corners and middles) along a line: even elements no longer than ``size`` between breaks."""
    corners = [breaks[0]]
    for low, high in pairwise(breaks):
        count = max(1, ceil((high - low) / size - 1e-6))
        corners.extend(low + (high - low) * step / count for step in range(1, count + 1))
    return with_middles(corners)


def between(nodes: Real, low: float, high: float) -> Real:
    """Those of sorted nodes that lie from ``low`` to ``high``."""
    return nodes[(nodes > low - RESOLUTION) & (nodes < high + RESOLUTION)]


def grid(y: Real, r: Real) -> Real:
    """Block (2 n + 1, 2 m + 1, 2) of points from y and r that broadcast against each other."""
    block: Real = np.stack(np.broadcast_arrays(y, r), axis=-1)
    return block


def joined(blocks: Sequence[Real]) -> SectionMesh:
    """Mesh of blocks: grids (2 n + 1, 2 m + 1, 2) whose first index runs along y, second along r.

    Nodes of different blocks at the same place become one; the centres of elements are left out.
    """
    points, elements, count = [], [], 0
    for block in blocks:
        along, across = block.shape[:2]
        number = count + np.arange(along * across).reshape(along, across)
        a, b, c = slice(0, -2, 2), slice(1, -1, 2), slice(2, None, 2)
        order = ((a, a), (c, a), (c, c), (a, c), (b, a), (c, b), (b, c), (a, b))
        elements.append(np.stack([number[place].ravel() for place in order], axis=1))
        points.append(block.reshape(-1, 2))
        count += along * across
    everything, corners = np.concatenate(points), np.concatenate(elements)
    # Rounding alone would split two nearly equal values that lie on either side of a rounding limit.
    keys = np.stack([_labels(everything[:, axis]) for axis in range(2)], axis=1)
    used = np.unique(corners)
    _, first, merged = np.unique(keys[used], axis=0, return_index=True, return_inverse=True)
    renumbered = np.zeros(count, dtype=np.int64)
    renumbered[used] = merged.ravel()
    return SectionMesh(everything[used][first], renumbered[corners])


def _labels(values: Real) -> NDArray[np.int64]:
    """Number of the cluster that each value belongs to: a new one starts where sorted values jump."""
    order = np.argsort(values)
    labels = np.empty(len(values), dtype=np.int64)
    labels[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > RESOLUTION)])
    return labels
