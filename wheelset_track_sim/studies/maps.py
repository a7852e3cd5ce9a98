"""Maps of an output over two axes: cells with contours and limit lines, or the draws of two distributions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..errors import InputError
from ..inputs import amounts, units
from ..inputs.schema import keyed, unknown
from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Real
from . import drawing
from .axes import Axis
from .outputs import label_of, unit_of

if TYPE_CHECKING:
    from .results import Results
    from .study import Study

CONTOURS = 8
"""Contours at round values, about so many."""


@dataclass(frozen=True)
class Map:
    """An output over two axes of the study, with lines at its limits."""

    type: ClassVar[str] = "map"

    name: str
    title: str
    x: str
    y: str
    output: str
    limits: tuple[Any, ...] = ()
    """Values of the output, such as ``350 kN``, at which a line is drawn."""
    at: Any = field(default_factory=dict)
    """Further axes of values, each with the value or label at which the map looks."""

    def __post_init__(self) -> None:
        keyed(self.at, "at", "axes with their values")

    def check(self, study: Study, where: str) -> None:
        """Raise InputError for an axis, a value or an output that the study does not have."""
        axes = {axis.name: axis for axis in study.axes}
        for key, name in (("x", self.x), ("y", self.y)):
            if name not in axes:
                raise InputError(unknown("axis of the study", f"{where}.{key} = {name!r}", name, [*axes]))
            if not axes[name].is_numeric:
                raise InputError(f"{where}.{key} = {name!r} has labels: give an axis of numbers")
        if self.x == self.y:
            raise InputError(f"{where}.y = {self.y!r} is x: give another axis of the study")
        if (axes[self.x].distribution is None) != (axes[self.y].distribution is None):
            raise InputError(f"{where} has a distribution along one axis only: give both axes values, or distributions")
        if self.output not in study.outputs:
            place = f"{where}.output = {self.output!r}"
            raise InputError(unknown("output of the study", place, self.output, study.outputs))
        self._limits(where)
        for name in self.at:
            if name not in axes or name in (self.x, self.y) or axes[name].distribution:
                known = [each for each, axis in axes.items() if each not in (self.x, self.y) and not axis.distribution]
                raise InputError(unknown("axis of values that is neither x nor y", f"{where}.at.{name}", name, known))
            axes[name].point(self.at[name], f"{where}.at.{name}")
        for name, axis in axes.items():
            if name not in (self.x, self.y, *self.at) and not axis.distribution:
                raise InputError(f"{where}.at has no {name}, which the study varies: give its value or label")

    def _limits(self, where: str = "limits") -> list[float]:
        """Limits in SI."""
        unit = unit_of(self.output)
        return [
            amounts.amount(each if isinstance(each, str) else f"{each!r}", unit, f"{where}.limits.{index}")
            for index, each in enumerate(self.limits)
        ]

    def draw(self, results: Results, out: Path) -> list[Path]:
        """Write the figure as PNG, SVG and PDF."""
        x, y = results.axis(self.x), results.axis(self.y)
        fixed = {name: results.axis(name).point(value, name) for name, value in self.at.items()}
        runs = [n for n in range(len(results.runs)) if all(results.point(n, at) == fixed[at] for at in fixed)]
        shown = units.for_people(unit_of(self.output))
        values = np.array([results.value(run, self.output) for run in runs]) / shown.size
        limits = [limit / shown.size for limit in self._limits()]
        notes = [results.made_by, *(f"{results.axis(name).meaning} {point.label}" for name, point in fixed.items())]
        if x.distribution:
            notes += [f"{len(values)} draws", *_shares(values, limits, shown.name)]
        with new_figure(5.4, self.title, "; ".join(notes)) as figure:
            axes = figure.subplots()
            at_x, at_y = (_of_people(results, runs, axis) for axis in (x, y))
            if x.distribution:
                mesh = _scattered(axes, at_x, at_y, values, limits)
            else:
                mesh = _cells(axes, *_grid(at_x, at_y, values), limits, shown.name)
            figure.colorbar(mesh, ax=axes, label=units.with_unit(label_of(self.output), shown.name))
            axes.set_xlabel(units.with_unit(x.meaning, units.for_people(x.unit).name))
            axes.set_ylabel(units.with_unit(y.meaning, units.for_people(y.unit).name))
            return drawing.save(out, self.name, figure)


def _of_people(results: Results, runs: list[int], axis: Axis) -> Real:
    """Values of an axis in the unit that people read: (runs,)."""
    size = units.for_people(axis.unit).size
    return np.array([results.point(run, axis.name).value for run in runs]) / size


def _grid(x: Real, y: Real, values: Real) -> tuple[Real, Real, Real]:
    """Distinct places along both axes, and the values (rows, columns) at them."""
    (columns, column), (rows, row) = (np.unique(each, return_inverse=True) for each in (x, y))
    grid = np.full((len(rows), len(columns)), np.nan)
    grid[row, column] = values
    return columns, rows, grid


def _cells(axes: Axes, columns: Real, rows: Real, grid: Real, limits: list[float], unit: str) -> Any:
    """A cell for each run, contours at round values, and a strong line at each limit, with its value."""
    masked = np.ma.masked_invalid(grid)
    mesh = axes.pcolormesh(columns, rows, masked, cmap="viridis", shading="nearest")
    mesh.set_rasterized(True)
    axes.set_facecolor("#d9d9d9")  # of runs that failed
    if min(grid.shape) < 2 or not masked.count():
        return mesh
    axes.set_xlim(columns[0], columns[-1])  # half of the outer cells, whose middle is simulated
    axes.set_ylim(rows[0], rows[-1])
    if np.ptp(masked.compressed()) > 0:
        round_values = MaxNLocator(CONTOURS).tick_values(masked.min(), masked.max())
        levels = [level for level in round_values if not np.isclose(level, limits).any()]
        contours = axes.contour(columns, rows, masked, levels, colors="white", linewidths=0.7)
        axes.clabel(contours, fontsize=8)
    for limit in limits:
        if masked.min() < limit < masked.max():
            line = axes.contour(columns, rows, masked, [limit], colors=COLOURS[0], linewidths=2.2)
            axes.clabel(line, fmt=f"{limit:g} {unit}".rstrip(), fontsize=9, colors=COLOURS[0])
    return mesh


def _scattered(axes: Axes, x: Real, y: Real, values: Real, limits: list[float]) -> Any:
    """A mark for each draw; those above the lowest limit have a ring."""
    above = values > min(limits, default=np.inf)
    look: Any = {"facecolor": "none", "edgecolor": COLOURS[0], "linewidth": 1.4, "s": 60}
    axes.scatter(x[above], y[above], **look)
    axes.grid(color="#e8e8ea", linewidth=0.6)
    axes.set_axisbelow(True)
    return axes.scatter(x, y, c=values, cmap="viridis", s=22)


def _shares(values: Real, limits: list[float], unit: str) -> list[str]:
    """Share of the draws above each limit."""
    known = values[np.isfinite(values)]
    return [f"{100 * np.mean(known > limit):.3g} % above {limit:g} {unit}".rstrip() for limit in limits if len(known)]


def limits_of(study: Study) -> Mapping[str, list[float]]:
    """Limits, SI, of each output that a map of the study has limits of."""
    found: dict[str, list[float]] = {}
    for each in study.drawings:
        if isinstance(each, Map) and each.limits:
            found[each.output] = sorted({*found.get(each.output, []), *each._limits()})
    return found
