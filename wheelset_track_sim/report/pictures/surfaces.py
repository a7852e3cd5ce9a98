"""Treads and rails that are not smooth: heights along them, and a map around the deepest place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from ...irregularities import line_steps, rail_heights, tread_heights
from ...irregularities.surface import RAILS
from ...runtime.arrays import Real
from ...scenario import WHEELS, Scenario
from ..figures import COLOURS

HALF_WIDTH = 0.036
"""Half of the width that is shown, m: that of the head of a 60E1 rail."""
AROUND = 0.15
"""Length of the map to either side of the deepest place, m."""
ACROSS = 49
"""Lines along the surface."""


@dataclass(frozen=True, eq=False)
class SurfaceHeights:
    """Heights of a tread or of a rail over the nominal surface."""

    name: str
    along: Real
    """Position along the track, or length around the tread from angle 0, (n,), m."""
    y: Real
    """Across, (m,), m, positive to the left."""
    heights: Real
    """(n, m), m, negative where material is missing."""
    around: float | None
    """Circumference of a tread, m."""


def irregular_surfaces(scenario: Scenario, steps_per_revolution: int) -> Iterator[SurfaceHeights]:
    """Treads and rails with irregularities, in the order wheel 1, wheel 2, rail 1, rail 2; raises InputError."""
    dx, found = scenario.step_length, scenario.irregularities
    y = np.linspace(-HALF_WIDTH, HALF_WIDTH, ACROSS)
    steps = line_steps(found, scenario.line_length, dx)
    for name in (*WHEELS, *RAILS):
        if not any(each.on == name for each in found):
            continue
        if name in WHEELS:
            heights = tread_heights(found, name, steps_per_revolution, dx, y)
        else:
            heights = rail_heights(found, name, steps, dx, y).all()
        along = np.arange(len(heights), dtype=np.float64) * dx
        yield SurfaceHeights(name, along, y, heights, along[-1] + dx if name in WHEELS else None)


def draw_along(axes: Axes, surface: SurfaceHeights) -> None:
    """Least and greatest height across, and that of the middle, along the whole surface."""
    unit, scale = _unit(surface)
    heights, position, label = surface.heights, surface.along, f"position along {_title(surface)} (m)"
    if surface.around is not None:  # what is at angle 0 in the middle
        half = len(heights) // 2
        heights, position = np.roll(heights, half, axis=0), (surface.along - half * surface.along[1]) / surface.around
        position, label = position * 360.0, f"angle on the tread of {_title(surface)} (°)"
    middle, least, most = heights[:, len(surface.y) // 2], heights.min(axis=1), heights.max(axis=1)
    if (most > least).any():
        axes.fill_between(position, least * scale, most * scale, color=COLOURS[1], alpha=0.25, lw=0, label="across")
    axes.plot(position, middle * scale, color=COLOURS[1], linewidth=0.9, label="middle")
    axes.set_xlim(*_irregular(position, most - least + np.abs(middle)) if surface.around is None else (-180.0, 180.0))
    axes.set_xlabel(label)
    axes.set_ylabel(f"height ({unit})")
    if surface.around is not None:
        axes.set_xticks(range(-180, 181, 45))
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, fontsize=9, borderaxespad=0.2)


def draw_map(axes: Axes, surface: SurfaceHeights) -> None:
    """Heights around the place that is farthest from the nominal surface, seen from above."""
    unit, scale = _unit(surface)
    count, dx = len(surface.along), surface.along[1] - surface.along[0]
    centre = int(np.abs(surface.heights).max(axis=1).argmax())
    reach = min(round(AROUND / dx), (count - 1) // 2)
    rows = np.arange(-reach, reach + 1)
    heights = surface.heights[(centre + rows) % count] * scale
    most = float(np.abs(heights).max()) or 1.0
    x = rows * dx * 1e3
    image = axes.imshow(
        heights.T[::-1],
        extent=(x[0], x[-1], surface.y[0] * 1e3, surface.y[-1] * 1e3),
        aspect="auto",
        interpolation="nearest",
        cmap="RdBu",
        vmin=-most,
        vmax=most,
    )
    at = surface.along[centre]
    where = f"{at:.2f} m" if surface.around is None else f"{(360.0 * at / surface.around + 180.0) % 360.0 - 180.0:.0f}°"
    axes.set_xlabel(f"from {where} on {_title(surface)} (mm)")
    axes.set_ylabel("y (mm)")
    bar = axes.figure.colorbar(image, ax=axes, pad=0.02)
    bar.set_label(f"height ({unit})")
    bar.outline.set_visible(False)


def _irregular(position: Real, deviation: Real) -> tuple[float, float]:
    """Part of a rail that is not smooth, with some of the smooth rail beside it."""
    place = position[deviation > 0.0]
    first, last = (place[0], place[-1]) if len(place) else (position[0], position[-1])
    beside = 0.5 * (last - first) + 0.1
    return max(position[0], first - beside), min(position[-1], last + beside)


def _title(surface: SurfaceHeights) -> str:
    return surface.name.replace("_", " ")


def _unit(surface: SurfaceHeights) -> tuple[str, float]:
    return ("mm", 1e3) if np.abs(surface.heights).max() >= 0.3e-3 else ("µm", 1e6)
