"""Figures of the page: small PNG files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wheelset_track_sim.report.figures import COLOURS, STYLE

from .store import ROOT

if TYPE_CHECKING:
    from .impact import Found
    from .runs import Passage

IMAGES = ROOT / "docs" / "images"
GREY = "#888888"
STEP_MS = 0.036
"""A step of 1 mm at 100 km/h, ms."""


@contextmanager
def _figure(name: str, height: float, columns: int) -> Iterator[tuple[Figure, Sequence[Axes]]]:
    with rc_context({**STYLE, "font.size": 9, "axes.titlesize": 9, "axes.titlelocation": "left"}):
        figure = Figure(figsize=(9.6, height), dpi=110, layout="constrained")
        yield figure, figure.subplots(1, columns)
        path: Path = IMAGES / f"validation_{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, metadata={"Software": None}, pil_kwargs={"optimize": True})


def impact_figure(
    functions: Mapping[str, Sequence[float]],
    before: Sequence[float],
    step: float,
    causal: Found,
    paper: Found,
    early: int,
) -> None:
    """Early Green's functions (per s), force histories of the impact, and peak force over creep."""
    with _figure("impact", 3.4, 3) as (_, (left, middle, right)):
        colours = dict(zip(functions, COLOURS, strict=False))
        for name, values in functions.items():
            left.plot(np.arange(len(values)) * STEP_MS, np.array(values) * 1e6, color=colours[name], label=name)
        first = next(iter(functions))
        there = -np.arange(len(before), -1, -1) * STEP_MS
        left.plot(there, np.array([*before, functions[first][0]]) * 1e6, ":", color=colours[first], label="lost")
        left.axhline(step * 1e6, color=GREY, linewidth=0.7)
        left.annotate(
            "G(0+), closed form", (0.98, step * 1e6), (0, 3), ha="right", textcoords="offset points", color=GREY
        )
        left.set(
            title="(a) moving Green's functions, 10⁻⁶ m/(N s)", xlabel="time (ms)", xlim=(-0.6, 1.0), ylim=(-1.2, 7)
        )
        left.legend(frameon=False, fontsize=7.5, loc="lower right")

        by = {variant.changes: run for variant, run in [*causal, *paper]}
        shown: dict[str, tuple[str, ...]] = {
            "causal": (),
            "paper, as printed": ("dynamics=paper",),
            "paper, folded": ("dynamics=paper", "lag_zero=folded"),
        }
        for (name, changes), colour in zip(shown.items(), (COLOURS[3], COLOURS[0], COLOURS[1]), strict=True):
            run = by[changes]
            middle.plot(np.array(run.x) * 1e3, run.force[0], color=colour, label=name)
        middle.plot([], [], color=GREY, label="wheel 2 (causal)")
        middle.plot(np.array(by[()].x) * 1e3, by[()].force[1], color=GREY, linewidth=0.8)
        middle.set(title="(b) contact force, kN", xlabel="distance from the sleeper (mm)", xlim=(-60, 120))
        middle.legend(frameon=False, fontsize=7.5)

        for label, found, mark, colour in (("causal", causal, "o", COLOURS[3]), ("paper", paper, "s", COLOURS[0])):
            right.plot(
                [run.creep[early] for _, run in found],
                [run.largest[0] for _, run in found],
                mark,
                color=colour,
                label=label,
                markersize=5,
            )
        right.axhline(358, color=GREY, linewidth=0.7)
        right.annotate("printed", (right.get_xlim()[1], 358), (-40, 3), textcoords="offset points", color=GREY)
        title = f"(c) peak force, kN, over creep at {early * STEP_MS:.2f} ms"
        right.set(title=title, xlabel="creep of rail and wheel (10⁻¹⁰ m/N)")
        right.legend(frameon=False, fontsize=7.5)


def ripple_figure(histories: Mapping[str, Passage], speeds: Sequence[float], forces: Sequence[Any]) -> None:
    """Force of wheel 1 without damage along two bays, and its extremes over speed."""
    with _figure("ripple", 3.2, 2) as (_, (left, right)):
        for (name, run), colour in zip(histories.items(), COLOURS, strict=False):
            left.plot(run.x, run.force[0], color=colour, label=name, linewidth=1.0)
        left.axhline(131, color=GREY, linewidth=0.7)
        left.annotate("printed maximum", (0.88, 131), (0, 3), ha="right", textcoords="offset points", color=GREY)
        left.set(title="(a) contact force of wheel 1, kN", xlabel="distance from a sleeper (m)", xlim=(-0.3, 0.9))
        left.legend(frameon=False, fontsize=7.5, ncols=2, loc="lower left")
        low, high = left.get_ylim()
        left.set_ylim(low - 12, high + 4)
        for (label, runs), colour in zip(forces, COLOURS, strict=False):
            right.plot(speeds, [run.largest[0] for run in runs], color=colour, label=label)
            right.plot(speeds, [run.smallest[0] for run in runs], color=colour)
        right.axhline(98.1, color=GREY, linewidth=0.7)
        right.set(title="(b) largest and smallest force of wheel 1, kN", xlabel="speed (km/h)")
        right.legend(frameon=False, fontsize=7.5)
