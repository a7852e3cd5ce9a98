"""Pictures of the structures: the wheelset's section, profiles of wheels on rails, supports along a line."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...contact.geometry import ContactGeometry, section
from ...runtime.arrays import Real
from ...track.supports import Along, along
from ...track.track import Track
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
            xytext=(0, 16 if z > 1e-3 else -22),  # below for the front: the top may have a node, too
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


HIGHEST, DEEPEST = 0.018, 0.022
"""Part of the profiles that is shown, m, above and below the top of the rail."""


def draw_profiles(axes: Axes, geometry: ContactGeometry, wheel: int) -> None:
    """Profiles of ``wheel`` (0 or 1) and its rail where they touch; heights twice as large as widths."""
    found = section(geometry, wheel)
    y, rail, tread = found.y * 1e3, found.rail * 1e3, found.wheel * 1e3
    floor = -DEEPEST * 1e3
    axes.fill_between(y, floor, rail, where=rail > floor, color="#d9d9d9", lw=0)
    axes.plot(y, rail, color="#444444", label=f"rail {wheel + 1}")
    axes.plot(y, tread, color=COLOURS[0], label=f"wheel {wheel + 1}")
    at, height = (value * 1e3 for value in found.touch)
    axes.plot(at, height, "o", color=COLOURS[1], markersize=5, label=f"contact, {at:+.1f} mm")
    circle = found.rolling_circle * 1e3
    axes.axvline(circle, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), label="rolling circle")
    axes.set_ylim(floor, HIGHEST * 1e3)
    axes.set_xlim(y[-1], y[0])  # y is positive to the left, and the picture looks ahead
    axes.set_aspect(2.0)
    axes.set_xlabel("y from the middle of the rail's head (mm)")
    axes.set_ylabel("height (mm)")
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=4,
        frameon=False,
        fontsize=8.5,
        borderaxespad=0.2,
        handlelength=1.0,
        columnspacing=0.9,
    )


RAILS = ("rail 1", "rail 2")


def uneven(track: Track) -> tuple[str, ...]:
    """Supports that differ along the line, ``pad`` and ``ballast``; none on a track that is the same everywhere."""
    if track.line is None:
        return ()
    found = along(track.line)
    kinds = {"pad": np.ptp(found.pad_stiffness) > 0, "ballast": np.ptp(found.ballast_stiffness) > 0}
    kinds["ballast"] |= bool(np.isfinite(found.gap).any())
    return tuple(kind for kind, differs in kinds.items() if differs)


def draw_supports(axes: Axes, track: Track, kind: str) -> None:
    """Stiffness (``pad`` or ``ballast``) under both rails, sleeper by sleeper; gaps under sleepers are marked."""
    assert track.line is not None
    found: Along = along(track.line)
    base = track.pad.stiffness if kind == "pad" else track.ballast.stiffness / 2  # type: ignore[union-attr]
    multiples = getattr(found, f"{kind}_stiffness")
    sleepers = np.arange(len(multiples))
    for side, marker in ((0, "o"), (1, "x")):
        axes.plot(
            sleepers,
            multiples[:, side] * base / 1e6,
            marker,
            color=COLOURS[side],
            markersize=4,
            linestyle="-",
            linewidth=0.6,
            label=RAILS[side],
        )
    if kind == "ballast":
        _mark_gaps(axes, found.gap)
    axes.set_ylim(bottom=0.0)
    axes.margins(y=0.15)
    axes.set_xlim(-0.5, len(sleepers) - 0.5)
    axes.set_xlabel("sleeper")
    axes.set_ylabel(f"{kind} stiffness\nper rail (MN/m)")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, fontsize=9, borderaxespad=0.2)


def _mark_gaps(axes: Axes, gap: Real) -> None:
    """A band at every sleeper that hangs, on either side."""
    hanging = np.flatnonzero(np.isfinite(gap).any(axis=1))
    widths = gap[np.isfinite(gap)] * 1e3
    for number, sleeper in enumerate(hanging):
        label = f"hangs, gap {widths.min():g}" + (f" to {widths.max():g}" if np.ptp(widths) else "") + " mm"
        axes.axvspan(sleeper - 0.4, sleeper + 0.4, color="#e69f00", alpha=0.4, lw=0, label="" if number else label)
