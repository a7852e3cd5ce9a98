"""Figures of a run: contact forces and principal stresses over the position along the track."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..errors import InputError
from ..recording import Recording
from .table import Comparison, comparison, description, scenario_of

COLOURS = ("#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
"""Told apart with every kind of colour vision (Okabe and Ito)."""
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
BEFORE, AFTER = 0.9, 1.8
"""Track shown before and after the largest force, m: about one turn of the wheel."""
BINS = 900
"""Width of the overview in minima and maxima."""


def plot_run(recording: Recording, path: Path) -> Path:
    """Write one picture (PNG) of the part of a run to look at closely: forces on top, stresses below.

    Raises InputError if the path cannot be written.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(9.6, 6.4), dpi=125, layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True)
        around = detail(recording, comparison(recording))
        draw_forces(top, recording, around)
        draw_stresses(bottom, recording, around)
        top.set_xlabel("")
        figure.suptitle(f"{recording.info.scenario_name}: {description(recording)}", fontsize=11, x=0.01, ha="left")
        content = io.BytesIO()
        figure.savefig(content, format="png")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.getvalue())
    except OSError as reason:
        raise InputError(f"{path} cannot be written ({reason.strerror}): give another path with --out") from None
    return path


def detail(recording: Recording, compared: Comparison | None) -> slice:
    """Samples to look at closely: the passage that the paper prints, or else those around the largest contact force.

    The whole run if it is not much longer than that.
    """
    position, length = recording.position, BEFORE + AFTER
    if position[-1] - position[0] <= 1.5 * length:
        return slice(0, len(recording))
    if compared:
        return compared.passage
    peak = position[int(recording.forces.max(axis=1).argmax())]
    first = min(max(peak - BEFORE, position[0]), position[-1] - length)
    start, stop = np.searchsorted(position, [first, first + length])
    return slice(int(start), int(stop))


def draw_forces(axes: Axes, recording: Recording, part: slice) -> None:
    """Contact forces of both wheels, kN."""
    mark_sleepers(axes, recording, part)
    scenario = scenario_of(recording)
    if scenario:
        axes.axhline(scenario.wheel_load / 1e3, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), label="static")
    curves(axes, recording, part, recording.forces / 1e3, ("wheel 1", "wheel 2"))
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    finish(axes, "contact force (kN)")


def draw_stresses(axes: Axes, recording: Recording, part: slice) -> None:
    """Maximum principal stress at every node, MPa."""
    mark_sleepers(axes, recording, part)
    curves(axes, recording, part, recording.max_principal / 1e6, recording.nodes)
    finish(axes, "max. principal stress (MPa)")


def curves(axes: Axes, recording: Recording, part: slice, values: NDArray[np.float64], names: tuple[str, ...]) -> None:
    """One curve a column; over many samples the band between minimum and maximum of each stretch."""
    position, values = recording.position[part], values[part]
    bands = len(position) > 8 * BINS
    starts = np.linspace(0, len(position), BINS, endpoint=False).astype(int)
    # The first curve is drawn last: the damaged wheel and the most stressed node lie on top.
    for column in reversed(range(values.shape[1])):
        curve, colour = values[:, column], COLOURS[column % len(COLOURS)]
        if bands:
            low, high = np.minimum.reduceat(curve, starts), np.maximum.reduceat(curve, starts)
            axes.fill_between(position[starts], low, high, color=colour, alpha=0.75, linewidth=0.4, label=names[column])
        else:
            axes.plot(position, curve, color=colour, label=names[column])
    axes.set_xlim(position[0], position[-1])


def mark_sleepers(axes: Axes, recording: Recording, part: slice) -> None:
    """A light vertical line above every sleeper, unless they would run together."""
    position, spacing = recording.position[part], recording.info.sleeper_spacing
    if not np.isfinite(spacing) or (position[-1] - position[0]) / spacing > 30:
        return
    first, last = np.ceil(position[0] / spacing), np.floor(position[-1] / spacing)
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


def svg(recording: Recording, draw: Any, part: slice, width: float, height: float, title: str) -> str:
    """One drawing as an SVG element that scales with the page; size in inches, ``title`` for screen readers."""
    # The salt keeps the identifiers of several drawings on one page apart, and makes them the same every time.
    with rc_context({**STYLE, "svg.hashsalt": f"{title} {width}"}):
        figure = Figure(figsize=(width, height), layout="constrained")
        draw(figure.subplots(), recording, part)
        content = io.StringIO()
        figure.savefig(content, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = content.getvalue()
    text = text[text.index("<svg") :]
    return text.replace("<svg", f'<svg role="img" aria-label="{title}"', 1)
