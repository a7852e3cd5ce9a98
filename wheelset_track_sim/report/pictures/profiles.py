"""Both wheels on their rails, in the plane of the axle."""

from __future__ import annotations

from matplotlib.axes import Axes

from ...contact.geometry import ContactGeometry, section
from ..figures import COLOURS

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
