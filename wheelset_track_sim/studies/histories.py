"""Figures of histories over the distance along the track."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from ..errors import InputError
from ..inputs import units
from ..inputs.schema import unknown
from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Real
from ..scenario import WHEELS
from . import drawing

if TYPE_CHECKING:
    from .results import Results
    from .study import Study


class Channel(NamedTuple):
    """What of a history is shown: ``part`` picks from the array, ``output`` names its extremes."""

    history: str
    part: tuple[Any, ...]
    quantity: str
    unit: str
    output: str = ""


CHANNELS = {
    "forces": Channel("forces", (), "contact force", "N", "wheels.{}.{}_force"),
    "principal": Channel("principal", (), "max. principal stress", "Pa", "nodes.{}.{}_principal"),
    "irregularity": Channel("irregularity", (), "irregularity", "m"),
    "wheel_displacement": Channel("displacements", (slice(None), 0), "wheel displacement, upwards", "m"),
    "rail_displacement": Channel("displacements", (slice(None), 1), "rail displacement, downwards", "m"),
}


DISTANCE = "distance from where angle 0 of the treads meets the rail (m)"


@dataclass(frozen=True)
class HistoryPanel:
    """One pair of axes: one channel of some wheels or stress nodes."""

    of: Literal["forces", "principal", "irregularity", "wheel_displacement", "rail_displacement"]
    columns: tuple[str, ...]
    """Wheels or stress nodes."""
    mark: tuple[Literal["max", "min"], ...] = ()
    """Extremes of the first column to mark with their value, beside the paper's if it prints one."""
    relative: bool = False
    """Whether values are shown less the first one in sight."""
    less: str = ""
    """Label of a run whose values are taken off those of the others."""
    title: str = ""


@dataclass(frozen=True)
class Histories:
    """Histories of all runs of a study, panels one above the other."""

    type: ClassVar[str] = "histories"

    name: str
    title: str
    panels: tuple[HistoryPanel, ...]
    before: float | None = None
    """Track that is shown before the reference position, m; all that is kept if None."""
    after: float | None = None
    """The same after it, m."""

    def check(self, study: Study, where: str) -> None:
        """Raise InputError for a history or a column that the study does not keep."""
        nodes = study.base()["output"]["stress_nodes"]
        if not self.panels:
            raise InputError(f"{where}.panels is empty: give at least one panel, with of: the history that it shows")
        for index, panel in enumerate(self.panels):
            history = CHANNELS[panel.of].history
            if history not in study.histories:
                raise InputError(f"{where}.panels.{index}.of = {panel.of!r} is not kept: put {history} into histories")
            if panel.less:
                runs = study.runs()
                if panel.less not in (labels := [run.label for run in runs]):
                    place = f"{where}.panels.{index}.less = {panel.less!r}"
                    raise InputError(unknown("run", place, panel.less, labels))
                if len({run.scenario.step_length for run in runs}) > 1:
                    raise InputError(
                        f"{where}.panels.{index}.less needs runs with the same step_length: vary only one of the two"
                    )
            known = nodes if panel.of == "principal" else WHEELS
            if not panel.columns:
                raise InputError(f"{where}.panels.{index}.columns is empty: give some of {', '.join(known)}")
            for name in panel.columns:
                if name not in known:
                    place = f"{where}.panels.{index}.columns has {name!r}, which"
                    raise InputError(unknown("column", place, name, known))

    def draw(self, results: Results, out: Path) -> list[Path]:
        """Write the figure as PNG and SVG."""
        heights = [1 if panel.of == "irregularity" else 2 for panel in self.panels]
        with new_figure(0.9 + 1.55 * sum(heights), self.title, results.made_by) as figure:
            stacked = figure.subplots(len(self.panels), 1, sharex=True, squeeze=False, height_ratios=heights).ravel()
            for axes, panel in zip(stacked, self.panels, strict=True):
                self._panel(axes, panel, results)
            stacked[-1].set_xlabel(DISTANCE)
            return drawing.save(out, self.name, figure)

    def _panel(self, axes: Axes, panel: HistoryPanel, results: Results) -> None:
        channel = CHANNELS[panel.of]
        shown = units.for_people(channel.unit)
        several = len(results.runs) > 1
        self._sleepers(axes, results)
        base = next((number for number in results.found if panel.less == results.runs[number].label), None)
        for number in sorted(set(results.found) - {base}, reverse=True):  # the first lies on top
            run = results.runs[number]
            names = run.scenario.output.stress_nodes if panel.of == "principal" else WHEELS
            values = results.found[number].arrays[channel.history][channel.part]
            distance, part = self._distance(results, number)
            taken_off = results.found[base].arrays[channel.history][channel.part] if base is not None else 0.0
            for order in reversed(range(len(panel.columns))):
                name = panel.columns[order]
                y = (values - taken_off)[part, names.index(name)] / shown.size
                y = y - y[0] if panel.relative else y
                colour = COLOURS[(number if several else order) % len(COLOURS)]
                labels = [run.label] if several else []
                labels += [name.replace("_", " ")] if not several or len(panel.columns) > 1 else []
                style: Any = {"color": colour, "linestyle": "-" if not several or order == 0 else (0, (4, 2))}
                axes.plot(distance[part], y, label=", ".join(labels), **style)
                if order == 0:
                    for extreme in panel.mark:
                        output = channel.output.format(name, extreme) if channel.output else ""
                        paper = results.published(number, output) / shown.size if output else math.nan
                        _mark(axes, distance[part], y, extreme, shown.name, paper, colour)
        axes.set_xlim(*(distance[part][[0, -1]] if results.found else (0, 1)))
        axes.margins(y=0.12)
        axes.set_title(panel.title, fontsize=10, loc="left")
        axes.set_ylabel(units.with_unit(channel.quantity, shown.name))
        handles, labels = axes.get_legend_handles_labels()
        if len(handles) > 1:
            axes.legend(handles[::-1], labels[::-1], fontsize=8.5, frameon=False, loc="best")

    def _distance(self, results: Results, number: int) -> tuple[Real, slice]:
        """Distance from the reference position, m, and the samples that are shown."""
        position = results.found[number].arrays["position"]
        distance = position - results.runs[number].scenario.reference_position
        low = -np.inf if self.before is None else -self.before - 1e-9
        high = np.inf if self.after is None else self.after + 1e-9
        first, last = np.searchsorted(distance, [low, high])
        return distance, slice(int(first), int(last))

    def _sleepers(self, axes: Axes, results: Results) -> None:
        """A light line above every sleeper."""
        if not results.found:
            return
        number = min(results.found)
        scenario = results.runs[number].scenario
        distance, part = self._distance(results, number)
        spacing, reference = scenario.track.spacing, scenario.reference_position
        low, high = distance[part][[0, -1]] + reference
        for sleeper in np.arange(math.ceil(low / spacing - 1e-9), math.floor(high / spacing + 1e-9) + 1):
            axes.axvline(sleeper * spacing - reference, color="#d9d9d9", linewidth=1.0, zorder=0)


def _mark(axes: Axes, x: Real, y: Real, extreme: str, unit: str, paper: float, colour: str) -> None:
    """Circle around the largest or smallest value, with the value."""
    at = int(y.argmax() if extreme == "max" else y.argmin())
    axes.plot(x[at], y[at], marker="o", markersize=7, markerfacecolor="none", color=colour, linestyle="none")
    text = f"{extreme} {y[at]:.4g} {unit}" + (f" (paper {paper:g} {unit})" if np.isfinite(paper) else "")
    right = x[at] > 0.5 * (x[0] + x[-1])
    axes.annotate(
        text,
        (x[at], y[at]),
        xytext=(-9 if right else 9, 0),
        textcoords="offset points",
        ha="right" if right else "left",
        va="center",
        fontsize=9,
    )
