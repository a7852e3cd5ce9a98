"""Section of a wheelset with its stress nodes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...wheelset.section_outline import SectionOutline
from ..figures import COLOURS

PARTS = {"axle": "#c9ccd1", "wheel_1": "#a9adb5", "wheel_2": "#a9adb5"}
OTHER = "#dfc9a3"


def draw_wheelset(axes: Axes, outline: SectionOutline) -> None:
    """Section in the plane of the axle seen in running direction, both halves, and the stress nodes on the surface."""
    for name, blocks in outline.parts.items():
        for block in blocks:
            for side in (1.0, -1.0):
                axes.fill(block[:, 0], side * block[:, 1], color=PARTS.get(name, OTHER), lw=0.4, ec="#666666")
    if not outline.parts:  # a wheelset that is known by its modes only
        for y, r in outline.contacts:
            axes.plot([y, y], [-r, r], color="#888888", linewidth=1.0, linestyle=(0, (4, 3)))
        axes.plot(outline.contacts[:, 0], [0.0, 0.0], color="#888888", linewidth=1.0, linestyle=(0, (4, 3)))
    for name, (first, last, radius) in outline.masses.items():
        middle = (first + last) / 2
        axes.plot([middle, middle], [-radius, radius], "s", color="#7a5c1e", markersize=5)
        axes.annotate(name, (middle, radius), xytext=(0, 5), textcoords="offset points", ha="center", fontsize=8.5)
    for number, (y, r) in enumerate(outline.contacts, start=1):
        axes.plot(y, -r, "^", color="#444444", markersize=6)
        axes.annotate(f"wheel {number}", (y, -r), xytext=(0, -14), textcoords="offset points", ha="center", fontsize=9)
    for name, (_, y, z) in zip(outline.node_names, outline.node_positions, strict=True):
        axes.plot(y, z, "o", color=COLOURS[0], markersize=5)
        axes.annotate(
            name,
            (y, z),
            xytext=(0, 16 if z >= 0 else -22),
            textcoords="offset points",
            ha="center",
            fontsize=9,
            color=COLOURS[0],
            arrowprops={"arrowstyle": "-", "color": COLOURS[0], "linewidth": 0.6},
        )
    low, high = np.min(outline.contacts[:, 0]), np.max(outline.contacts[:, 0])
    reach = max([high, -low, *(np.abs(block[:, 0]).max() for blocks in outline.parts.values() for block in blocks)])
    axes.set_xlim(1.04 * reach, -1.04 * reach)  # y is positive to the left, and the picture looks ahead
    axes.set_aspect("equal")
    axes.margins(y=0.12)
    axes.set_xlabel("y (m)")
    axes.set_ylabel("z (m)")
