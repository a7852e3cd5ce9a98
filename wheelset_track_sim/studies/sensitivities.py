"""Sensitivities of outputs to what a study draws from distributions: Sobol's indices, as bars."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..errors import InputError
from ..inputs.schema import unknown
from ..report.figures import COLOURS, new_figure
from ..runtime.arrays import Real
from . import drawing
from .outputs import label_of
from .sampling import sobol_indices

if TYPE_CHECKING:
    from .results import Results
    from .study import Study

DESIGN = "saltelli"
HALF = 0.18
"""Half the distance between the bars of a pair."""


class Indices(NamedTuple):
    """Sobol's indices of an output: estimate, and half of its interval of 95 %, (axes, 2) each."""

    first: Real
    """Share of the variance that an axis makes alone."""
    total: Real
    """The same together with all others."""


def indices(results: Results, output: str) -> Indices | None:
    """Indices of an output, in the order of the axes; None if runs failed, or if it is the same in all of them."""
    values = np.array([results.value(run, output) for run in range(len(results.runs))])
    sampling = results.study.sampling
    if sampling is None or sampling.method != DESIGN or not np.isfinite(values).all() or not np.ptp(values) > 0:
        return None
    return Indices(*sobol_indices(values, len(results.axes), sampling.seed))


@dataclass(frozen=True)
class Sensitivities:
    """Sobol's indices of some outputs, side by side."""

    type: ClassVar[str] = "sensitivities"

    name: str
    title: str
    outputs: tuple[str, ...]

    def check(self, study: Study, where: str) -> None:
        """Raise InputError for an output that the study does not have, or another design than ``saltelli``."""
        if study.sampling is None or study.sampling.method != DESIGN:
            raise InputError(f"{where} needs the design saltelli: give sampling: {{method: saltelli}}")
        for index, name in enumerate(self.outputs):
            if name not in study.outputs:
                place = f"{where}.outputs.{index} = {name!r}"
                raise InputError(unknown("output of the study", place, name, study.outputs))
        if not self.outputs:
            raise InputError(f"{where}.outputs is empty: give at least one output of the study")

    def draw(self, results: Results, out: Path) -> list[Path]:
        """Write the figure as PNG, SVG and PDF."""
        names = [axis.meaning for axis in results.axes]
        made = f"{results.made_by}; {len(results.runs)} runs; bars: intervals of 95 % by bootstrap"
        with new_figure(1.4 + (0.5 + 0.42 * len(names)) * len(self.outputs), self.title, made) as figure:
            grid = figure.subplots(len(self.outputs), 1, sharex=True, squeeze=False).ravel()
            for axes, output in zip(grid, self.outputs, strict=True):
                found = indices(results, output)
                for kind, offset, colour in (("first order", -HALF, COLOURS[1]), ("total", HALF, COLOURS[0])):
                    if found is not None:
                        share, half = (found.first if offset < 0 else found.total).T
                        at = np.arange(len(names)) + offset
                        axes.barh(at, share, 2 * HALF, xerr=half, color=colour, label=kind, ecolor="#444444")
                axes.set_yticks(range(len(names)), names)
                axes.set_ylim(len(names) - 0.5, -0.5)
                axes.set_title(label_of(output), fontsize=10, loc="left")
                axes.grid(axis="x", color="#e8e8ea", linewidth=0.6)
                axes.set_axisbelow(True)
            grid[-1].set_xlabel("share of the variance")
            grid[0].legend(fontsize=9, frameon=False)
            return drawing.save(out, self.name, figure)
