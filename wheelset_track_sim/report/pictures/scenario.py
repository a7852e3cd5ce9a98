"""One picture of a scenario: irregular treads and rails, profiles, supports that differ, the wheelset's section."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import SubFigure

from ...errors import printable
from ...runtime.progress import Progress
from ...scenario import WHEELS, Profiles, Scenario
from ...scenario.scenario import WHEELSET
from ...wheelset.kinds import load_wheelset, reduce_wheelset
from ...wheelset.section_outline import section_outline
from ..figures import new_figure, write_picture
from .structures import draw_profiles, draw_supports, draw_wheelset, uneven
from .surfaces import SurfaceHeights, draw_along, draw_map, irregular_surfaces

SPACE = 0.1
"""Space below the title and above the note, inches."""


class PictureRow(NamedTuple):
    """A row of the picture."""

    height: float
    """inches"""
    draw: Callable[[SubFigure], None]
    special: bool
    """Whether it differs from that of the paper's wheelset on the paper's track."""


def show_scenario(scenario: Scenario, path: Path, progress: Progress | None = None) -> Path:
    """Write the picture (PNG, SVG or PDF) of a scenario; returns its path.

    Raises InputError for a scenario that cannot be used, as the simulator does, and for a path that cannot be written.
    """
    return write_rows(path, printable(scenario.name), description(scenario), rows_of(scenario, progress))


def write_rows(path: Path, title: str, note: str, rows: Sequence[PictureRow]) -> Path:
    """Write rows as one picture; returns its path. Raises InputError for a path that cannot be written."""
    heights = [SPACE, *(row.height for row in rows), SPACE]
    with new_figure(sum(heights), title, note) as figure:
        parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)
        for part, row in zip(parts[1:-1, 0], rows, strict=True):
            row.draw(part)
        return write_picture(figure, path)


def rows_of(scenario: Scenario, progress: Progress | None = None) -> list[PictureRow]:
    """What there is to see of a scenario, from its treads to its wheelset; raises InputError."""
    wheelset, track, geometry = scenario.touched_wheelset, scenario.track, scenario.geometry
    model = reduce_wheelset(wheelset, progress)
    outline = section_outline(wheelset, model)
    turn = scenario.steps_per_revolution

    def surface_row(surface: SurfaceHeights) -> PictureRow:
        def draw(part: SubFigure) -> None:
            along, around = part.subplots(1, 2, width_ratios=(1.5, 1.0))
            draw_along(along, surface)
            draw_map(around, surface)

        return PictureRow(2.4, draw, special=True)

    def profiles(part: SubFigure) -> None:
        # Seen in running direction, wheel 2 is on the left.
        for axes, wheel in zip(part.subplots(1, 2), reversed(range(len(WHEELS))), strict=True):
            draw_profiles(axes, geometry, wheel)

    def supports(part: SubFigure) -> None:
        kinds = uneven(track)
        for axes, kind in zip(part.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True):
            draw_supports(axes, track, kind)

    rows = [surface_row(surface) for surface in irregular_surfaces(scenario, turn)]
    rows.append(PictureRow(2.9, profiles, special=scenario.profiles != Profiles()))
    if uneven(track):
        rows.append(PictureRow(2.4, supports, special=True))
    rows.append(
        PictureRow(
            4.2,
            lambda part: draw_wheelset(part.subplots(), outline),
            special=scenario.wheelset != load_wheelset(WHEELSET),
        )
    )
    return rows


def description(scenario: Scenario) -> str:
    """Wheelset, track, load and speed in a line."""
    load = f"{scenario.axle_load / 1e3:.1f} kN on both wheels, {3.6 * scenario.speed:.0f} km/h"
    above = f" under {scenario.vehicle.name}" if scenario.vehicle else ""
    return f"{scenario.wheelset.name}{above} on {scenario.track.name}, {load}"
