"""Figures of outputs over what is varied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..errors import InputError
from ..inputs import units
from ..inputs.schema import keyed, unknown
from ..report.figures import COLOURS, LIMIT_COLOURS, new_figure
from . import drawing
from .axes import Axis, Point
from .outputs import FORCES, extreme_of, place_of, quantity_of, unit_of

if TYPE_CHECKING:
    from .results import Results
    from .study import Study

DASHES = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
MARKERS = ("o", "s", "^", "D", "v")
MOST_MARKERS = 25
BESIDE = 0.16
PAPER: Any = {"markersize": 9, "markerfacecolor": "none", "linestyle": "none", "clip_on": False, "zorder": 5}
"""What the paper prints: a large hollow marker of the same shape and colour."""
PARTS = (quantity_of, place_of, extreme_of)


@dataclass(frozen=True)
class Panel:
    """One pair of axes: outputs of one unit, all runs of the study or those at some points of its axes."""

    y: tuple[str, ...]
    title: str = ""
    at: Any = field(default_factory=dict)
    """Axes with the value or label at which the panel looks."""

    def __post_init__(self) -> None:
        keyed(self.at, "at", "axes with their values")


@dataclass(frozen=True)
class Lines:
    """Outputs over one axis of the study, a curve for each combination of the others; labels stand side by side."""

    type: ClassVar[str] = "lines"

    name: str
    title: str
    x: str
    panels: tuple[Panel, ...]
    x_label: str = ""
    """What the axis is called; its meaning in the scenario if empty."""
    columns: Literal[1, 2] = 2
    """Panels side by side."""

    def check(self, study: Study, where: str) -> None:
        """Raise InputError for an axis, a value or an output that the study does not have."""
        axes = {axis.name: axis for axis in study.axes}
        if self.x not in axes:
            raise InputError(unknown("axis of the study", f"{where}.x = {self.x!r}", self.x, [*axes]))
        if any(axis.distribution for axis in study.axes):
            raise InputError(
                f"{where} has lines, which need axes of values: draw distributions as map or sensitivities"
            )
        if not self.panels:
            raise InputError(f"{where}.panels is empty: give at least one panel with its outputs y")
        for index, panel in enumerate(self.panels):
            place = f"{where}.panels.{index}"
            for name in panel.y:
                if name not in study.outputs:
                    raise InputError(unknown("output of the study", f"{place}.y = {name!r}", name, study.outputs))
            if not panel.y or len({unit_of(name) for name in panel.y}) > 1:
                raise InputError(f"{place}.y has {', '.join(panel.y) or 'nothing'}: give outputs of one unit")
            for name, value in panel.at.items():
                if name not in axes or name == self.x:
                    raise InputError(unknown("axis that is not x", f"{place}.at.{name}", name, [*axes]))
                axes[name].point(value, f"{place}.at.{name}")

    def draw(self, results: Results, out: Path) -> list[Path]:
        """Write the figure as PNG and SVG."""
        columns = min(self.columns, len(self.panels))
        rows = -(-len(self.panels) // columns)
        with new_figure(3.9 * rows + 0.5, self.title, results.made_by) as figure:
            grid = figure.subplots(rows, columns, squeeze=False).ravel()
            for axes, panel in zip(grid, self.panels, strict=False):
                self._panel(axes, panel, results)
            for axes in grid[len(self.panels) :]:
                axes.remove()
            self._align([*grid])
            return drawing.save(out, self.name, figure)

    def _align(self, grid: Sequence[Axes]) -> None:
        """Panels of the same outputs are there to be compared: one scale for all of them."""
        same = [axes for axes, panel in zip(grid, self.panels, strict=False) if panel.y == self.panels[0].y]
        low, high = (pick(axes.get_ylim()[end] for axes in same) for end, pick in ((0, min), (1, max)))
        for axes in same:
            axes.set_ylim(low, high)

    def _panel(self, axes: Axes, panel: Panel, results: Results) -> None:
        along = results.axis(self.x)
        size, shown = units.for_people(along.unit).size, units.for_people(unit_of(panel.y[0]))
        curves = _curves(results, self.x, panel)
        compared = False
        for number, indices in enumerate(curves.values()):
            x = np.array([_place(along, results.point(index, self.x)) for index in indices]) / size
            for order, name in enumerate(panel.y):
                look: Any = {"color": COLOURS[(number if len(curves) > 1 else order) % len(COLOURS)]}
                look["marker"] = MARKERS[order % len(MARKERS)]
                # Labels have no order: points stand side by side, with no line between.
                at = x if along.is_numeric else x + BESIDE * (order - (len(panel.y) - 1) / 2)
                kind = DASHES[order % len(DASHES)] if along.is_numeric else "none"
                y = np.array([results.value(index, name) for index in indices]) / shown.size
                axes.plot(at, y, linestyle=kind, markersize=4 if len(x) <= MOST_MARKERS else 0, **look)
                low, high = np.array([results.ends(index, name) for index in indices]).T / shown.size
                if np.isfinite(low).any() and along.is_numeric:
                    axes.fill_between(at, low, high, color=look["color"], alpha=0.2, linewidth=0)
                elif np.isfinite(low).any():
                    axes.vlines(at, low, high, color=look["color"], alpha=0.5)
                paper = np.array([results.published(index, name) for index in indices]) / shown.size
                compared = compared or bool(np.isfinite(paper).any())
                axes.plot(at, paper, **PAPER, **look)
        low, high = (float(end) for end in axes.get_ylim())
        axes.set_ylim(low if low > 0.5 * high else min(0.0, 0.0 if low > -0.1 * high else low), high)
        limits = results.limits.force if results.limits else ()
        for limit in limits if {*panel.y} <= {*FORCES} else ():
            line = limit.above / shown.size
            if line <= high:
                colour = LIMIT_COLOURS[limit.level]
                axes.axhline(line, linewidth=1.0, zorder=0, color=colour)
                small: Any = {"ha": "right", "va": "bottom", "fontsize": 8, "xycoords": ("axes fraction", "data")}
                axes.annotate(f"{limit.level} {line:.4g} {shown.name}", (1.0, line), color=colour, **small)
        axes.set_ylabel(units.with_unit(_common(panel.y), shown.name))
        axes.set_xlabel(self.x_label or units.with_unit(along.meaning, units.for_people(along.unit).name))
        if not along.is_numeric:
            axes.set_xticks(range(len(along.points)), [point.label for point in along.points], rotation=20, ha="right")
            axes.set_xlim(-0.5, len(along.points) - 0.5)
            axes.set_xlabel(self.x_label)
        axes.grid(color="#e8e8ea", linewidth=0.6)
        self._legend(axes, panel, [*curves], along.is_numeric, compared)

    def _legend(self, axes: Axes, panel: Panel, curves: list[str], joined: bool, compared: bool) -> None:
        """Colours and dashes told one by one, in a line above the panel, with its title on top."""
        handles, grey = [], "#666666"
        if len(curves) > 1:
            drawn: Any = {} if joined else {"linestyle": "none", "marker": MARKERS[0], "markersize": 4}
            colours = [COLOURS[number % len(COLOURS)] for number in range(len(curves))]
            handles += [Line2D([], [], color=c, label=text, **drawn) for c, text in zip(colours, curves, strict=True)]
        if len(panel.y) > 1:
            for order, name in enumerate(panel.y):
                colour = grey if len(curves) > 1 else COLOURS[order % len(COLOURS)]
                kind = DASHES[order % len(DASHES)] if joined else "none"
                look: Any = {"color": colour, "linestyle": kind, "marker": MARKERS[order % len(MARKERS)]}
                handles.append(Line2D([], [], markersize=4, label=_differing(panel.y, name), **look))
        if compared:
            handles.append(Line2D([], [], marker="o", color=grey, label="paper", **PAPER))
        axes.set_title(panel.title, fontsize=10, loc="left", pad=20 if handles else 6)
        if handles:
            small: Any = {"handlelength": 1.6, "handletextpad": 0.4, "columnspacing": 0.9, "borderaxespad": 0.2}
            where: Any = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncol": len(handles)}
            axes.legend(handles=handles, fontsize=8.5, frameon=False, **small, **where)


def _curves(results: Results, x: str, panel: Panel) -> dict[str, list[int]]:
    """Indices of the runs of each curve, by label."""
    fixed = {name: results.axis(name).point(value, name).label for name, value in panel.at.items()}
    curves: dict[str, list[int]] = {}
    for index, run in enumerate(results.runs):
        places = list(zip(results.axes, run.points, strict=True))
        if all(fixed.get(axis.name, point.label) == point.label for axis, point in places):
            others = [_named(axis, point.label) for axis, point in places if axis.name not in (x, *fixed)]
            curves.setdefault(", ".join(others), []).append(index)
    return curves


def _named(axis: Axis, label: str) -> str:
    return f"{axis.meaning} {label}" if axis.is_numeric or len(label) <= 2 else label


def _place(axis: Axis, point: Point) -> float:
    """Where a point stands along an axis: its value, or the position of its label."""
    return float(point.value) if axis.is_numeric else float(axis.points.index(point))


def _common(names: tuple[str, ...]) -> str:
    """What several outputs have in common, in words."""
    quantities, places, extremes = ({of(name) for name in names} for of in PARTS)
    phrase = " / ".join(sorted(quantities))
    phrase += f" {places.pop()}" if len(places) == 1 else ""
    return phrase + (f", {extreme}" if len(extremes) == 1 and (extreme := extremes.pop()) else "")


def _differing(names: tuple[str, ...], name: str) -> str:
    """What tells one of several outputs apart, in words."""
    return " ".join(of(name) for of in PARTS[1:] if len({of(other) for other in names}) > 1)
