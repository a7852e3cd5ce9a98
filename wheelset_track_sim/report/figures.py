"""Figures: one look for all, and the picture of a run, forces and principal stresses over the position on the track."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import InputError
from ..runtime.arrays import Real
from ..version import __version__
from .files import write_whole
from .samples import SampleSeries
from .survey import Survey
from .table import description, made_by, title

COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
"""Told apart with every kind of colour vision (Okabe and Ito)."""
WIDTH = 9.6
"""Width of a figure, inches: 1200 pixels, legible at the width of a page."""
DOTS = 125
NOTE = 150
"""Letters in a line of the note below a figure."""
QUIET = "#5a5a5f"
LIMIT_COLOURS = {"warning": "#b8860b", "alarm": "#a00000"}
NEAR = 1.05
"""Share of the largest force up to which limits are drawn."""
MADE_WITH = f"wheelset_track_sim {__version__}"
STYLE: Any = {
    "font.family": "sans-serif",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#444444",
    "axes.linewidth": 0.8,
    "lines.linewidth": 1.2,
    "svg.fonttype": "none",
}


PICTURES: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""Forms of pictures by suffix, with what would tell the time or the program's version and is left out."""


@contextmanager
def new_figure(height: float, title: str, made_by: str) -> Iterator[Figure]:
    """Figure in the style of the reports, with its title and, in grey, what made it and this version."""
    with rc_context({**STYLE, "svg.hashsalt": title, "mathtext.default": "regular"}):
        figure = Figure(figsize=(WIDTH, height), dpi=DOTS, layout="constrained")
        figure.suptitle(title, fontsize=12, x=0.01, ha="left", parse_math=False)
        add_note(figure, f"{made_by.removesuffix('.')}. {MADE_WITH}")
        yield figure


def add_note(figure: Figure, text: str) -> None:
    """Small print in grey below a figure."""
    lines = "\n".join(textwrap.wrap(text, NOTE))
    figure.supxlabel(lines, fontsize=8.5, x=0.01, ha="left", color=QUIET, parse_math=False)


def plot_run(run: Survey, path: Path) -> Path:
    """Write one picture (PNG, SVG or PDF) of the part of a run to look at closely: forces on top, stresses below.

    Raises InputError if the path cannot be written.
    """
    with rc_context({**STYLE, "svg.hashsalt": run.info.digest}):
        figure = Figure(figsize=(WIDTH, 6.4), dpi=DOTS, layout="constrained")
        axes = figure.subplots(2 if run.nodes else 1, 1, sharex=True, squeeze=False)[:, 0]
        part = detail(run)
        draw_forces(axes[0], run, part)
        if run.nodes:
            axes[0].set_xlabel("")
            draw_stresses(axes[1], run, part)
        figure.suptitle(f"{title(run)}\n{description(run)}", fontsize=11, x=0.01, ha="left", parse_math=False)
        add_note(figure, made_by(run))
        return write_picture(figure, path)


def check_picture(path: Path) -> None:
    """Raise InputError unless a path names a picture by its suffix."""
    if path.suffix.lower() not in PICTURES:
        raise InputError(f"{path} is not a picture: give a name that ends in {', '.join(PICTURES)}")


def write_picture(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG, SVG or PDF, by its suffix, whole or not at all; returns ``path``.

    Raises InputError if that cannot be written. The same figure makes the same file.
    """
    check_picture(path)
    content, suffix = io.BytesIO(), path.suffix.lower()
    figure.savefig(content, format=suffix.removeprefix("."), metadata=PICTURES[suffix])
    return write_whole(path, content.getvalue())


def detail(run: Survey) -> SampleSeries:
    """Samples to look at closely: the passage that the paper prints, or else those around the largest contact force."""
    return run.passage.samples if run.passage else run.closeups[0].samples


def draw_forces(axes: Axes, run: Survey, part: SampleSeries) -> None:
    """Contact forces of both wheels, kN."""
    mark_sleepers(axes, part, run.info.sleeper_spacing)
    if not math.isnan(run.wheel_load):
        axes.axhline(run.wheel_load / 1e3, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), label="static")
    curves(axes, part, part.forces / 1e3, ("wheel 1", "wheel 2"))
    for limit in run.limits.force if run.limits else ():
        if limit.above <= NEAR * part.forces.max():
            name = f"{limit.level} {limit.above / 1e3:.4g} kN"
            axes.axhline(limit.above / 1e3, color=LIMIT_COLOURS[limit.level], linewidth=1.0, label=name)
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    finish(axes, "contact force (kN)")


def draw_stresses(axes: Axes, run: Survey, part: SampleSeries) -> None:
    """Maximum principal stress at every node, MPa."""
    mark_sleepers(axes, part, run.info.sleeper_spacing)
    curves(axes, part, part.max_principal / 1e6, run.nodes)
    finish(axes, "max. principal stress (MPa)")


def curves(axes: Axes, part: SampleSeries, values: Real, names: tuple[str, ...]) -> None:
    """One curve a column."""
    # The first curve is drawn last: the damaged wheel and the most stressed node lie on top.
    for column in reversed(range(values.shape[1])):
        axes.plot(part.position, values[:, column], color=COLOURS[column % len(COLOURS)], label=names[column])
    axes.set_xlim(part.position[0], part.position[-1])


def mark_sleepers(axes: Axes, part: SampleSeries, spacing: float) -> None:
    """A light vertical line above every sleeper."""
    if math.isnan(spacing):
        return
    first, last = np.ceil(part.position[0] / spacing), np.floor(part.position[-1] / spacing)
    for index, number in enumerate(np.arange(first, last + 1)):
        axes.axvline(number * spacing, color="#d9d9d9", linewidth=1.0, zorder=0, label="" if index else "sleeper")


def finish(axes: Axes, quantity: str) -> None:
    """Labels with units, legend above the curves."""
    axes.set_ylabel(quantity)
    axes.set_xlabel("position along the track (m)")
    handles, labels = axes.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=lambda index: (labels[index] in ("static", "sleeper"), labels[index]))
    axes.legend(
        [handles[index] for index in order],
        [labels[index] for index in order],
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=len(order),
        frameon=False,
        fontsize=9,
        handlelength=1.0,
        handletextpad=0.5,
        columnspacing=0.9,
        borderaxespad=0.2,
    )
