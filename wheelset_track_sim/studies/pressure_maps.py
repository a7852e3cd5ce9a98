"""Maps of the contact pressure: runs one below the other, instants side by side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.patches import Ellipse

from ..contact.hardness import flag
from ..errors import InputError
from ..irregularities import breakouts
from ..report.figures import new_figure
from . import drawing

if TYPE_CHECKING:
    from .results import Results
    from .study import Study

MEANING = {"reference": "centre of the defect at the rail", "max_force": "maximum contact force"}
MARGIN = 2.5e-3
"""Shown around the contacts, m."""
LEAST = 1e-3
"""Share of the largest pressure below which an element counts as out of contact in the drawing."""


@dataclass(frozen=True)
class PressureMaps:
    """Contact pressures of one wheel at the instants that the study keeps."""

    type: ClassVar[str] = "pressure_maps"

    name: str
    title: str
    wheel: Literal["wheel_1", "wheel_2"] = "wheel_1"

    def check(self, study: Study, where: str) -> None:
        """Raise InputError if the study keeps no contact pressure of the wheel."""
        if not self._kept(study):
            raise InputError(f"{where}.wheel = {self.wheel} has no pressure: put {self.wheel}.max_force into pressures")

    def _kept(self, study: Study) -> list[str]:
        return [name for name in study.pressures if name.startswith(f"{self.wheel}.")]

    def draw(self, results: Results, out: Path) -> list[Path]:
        """Write the figure as PNG and SVG."""
        kept, numbers = self._kept(results.study), sorted(results.found)
        if not numbers:
            return []
        arrays = [results.found[number].arrays for number in numbers]
        peak = max(float(found[f"{name}.pressure"].max()) for found in arrays for name in kept)
        reach = np.array([_reach(found[f"{name}.pressure"], found, name) for found in arrays for name in kept])
        half_x, half_y = 1e3 * (reach.max(axis=0) + MARGIN)
        rows = len(numbers)
        height = 1.1 + rows * (0.5 + 7.2 / len(kept) * half_y / half_x)
        made = f"{results.made_by}.\nDashed: rim of the defect. White: no contact. Running direction to the right."
        with new_figure(height, self.title, made) as figure:
            grid = figure.subplots(rows, len(kept), sharex=True, sharey=True, squeeze=False)
            for row, number in zip(grid, numbers, strict=True):
                for axes, name in zip(row, kept, strict=True):
                    mesh = self._map(axes, results, number, name, peak)
                    axes.set_xlim(-half_x, half_x)
                    axes.set_ylim(-half_y, half_y)
                row[0].set_ylabel("lateral, from the middle of the rail (mm)")
            for axes in grid[-1]:
                axes.set_xlabel("along the track, from the contact point (mm)")
            figure.colorbar(mesh, ax=grid, label="contact pressure (GPa)", shrink=0.6)
            return drawing.save(out, self.name, figure)

    def _map(self, axes: Axes, results: Results, number: int, name: str, peak: float) -> QuadMesh:
        run, arrays = results.runs[number], results.found[number].arrays
        pressure, (position, force, circle) = arrays[f"{name}.pressure"], arrays[f"{name}.at"]
        shown = np.where(pressure > LEAST * peak, pressure, np.nan)
        x, y = 1e3 * arrays[f"{name}.x"], 1e3 * arrays[f"{name}.y"]
        mesh = axes.pcolormesh(x, y, shown.T / 1e9, vmin=0, vmax=peak / 1e9, cmap="inferno_r", shading="nearest")
        mesh.set_rasterized(True)
        behind = 1e3 * (position - run.scenario.reference_position)
        for defect in breakouts(run.scenario.irregularities):
            if defect.on == self.wheel and defect.angle == 0:
                rim: Any = {"fill": False, "linestyle": (0, (4, 3)), "linewidth": 0.9, "edgecolor": "#444444"}
                centre = (
                    -behind,
                    1e3 * (circle + defect.y),
                )  # what met the rail before is behind the contact point now
                axes.add_patch(Ellipse(centre, 2e3 * defect.a, 2e3 * defect.b, **rim))
        axes.set_aspect("equal")
        instant = f"{run.label}, {MEANING[name.split('.')[1]]}"
        figures = f"{force / 1e3:.1f} kN, peak {pressure.max() / 1e9:.2f} GPa, at {behind:.0f} mm"
        flagged = flag(pressure, run.scenario.contact.largest_pressure)
        axes.set_title("\n".join(filter(None, (instant, figures, flagged))), fontsize=9, loc="left")
        return mesh


def _reach(pressure: np.ndarray, arrays: dict[str, np.ndarray], name: str) -> tuple[float, float]:
    """Largest distances along and across from the contact point to an element in contact, m."""
    at_x, at_y = np.nonzero(pressure > 0)
    if not len(at_x):
        return 0.0, 0.0
    return float(np.abs(arrays[f"{name}.x"][at_x]).max()), float(np.abs(arrays[f"{name}.y"][at_y]).max())
