"""What sensors gave, in the page of a run: a table of all, and their signals around the largest force."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.models.layouts import LayoutDOM
from bokeh.plotting import figure

from ..samples.spectra import reference_of
from .plots import COLOURS, below_one_another, curves, finish, over_an_axis, zoomable
from .sensor_figures import AFTER, BEFORE, SensorFigures

MOST = 12
"""Sensors that are drawn."""


def section(figures: Sequence[SensorFigures], plot: str) -> str:
    """Table and plots of the sensors; nothing without sensors."""
    head = "<th>sensor</th><th>samples</th><th>largest size</th><th>root of the mean square</th>"
    lines = "".join(
        f"<tr><td>{escape(f'{each.topic} {name}')}</td><td>{each.samples}</td>"
        f"<td>{each.peak[name]:.4g} {_unit(each)}</td><td>{each.rms(name):.4g} {_unit(each)}</td></tr>"
        for each in figures
        for name in each.peak
    )
    drawn = (
        "What the sensors give, around the largest contact force; below, levels in one-third-octave bands of their "
        "whole run, by Welch’s method."
    )
    more = f" The first {MOST} sensors are drawn." if len(figures) > MOST else ""
    return (
        f'<h2 id="sensors">Sensors</h2><div class="list"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{lines}</tbody></table></div>{plot}"
        f'<p class="quiet">{drawn}{more}</p>'
    )


def sensor_plots(figures: Sequence[SensorFigures], at: float) -> LayoutDOM:
    """Signals of each sensor around the time ``at``, s."""
    plots = []
    shared = Range1d(at - BEFORE, at + AFTER, bounds=(at - BEFORE, at + AFTER), min_interval=1e-3)
    for each in figures[:MOST]:
        names = [f"{each.topic} {name}" for name in each.shown]
        columns = {f"value{number}": np.concatenate(parts) for number, parts in enumerate(each.shown.values())}
        source = ColumnDataSource({"time": np.concatenate(each.time), **columns})
        plot = over_an_axis(_unit(each) or "strain", shared, 240)
        digits = "0.0" if each.unit in ("m/s^2", "N") else "0.000e+0"
        curves(plot, source, range(len(names)), names, _unit(each), digits=digits)
        plots.append(plot)
    plots[-1].xaxis.axis_label = "simulated time (s)"
    for plot in plots[:-1]:
        plot.xaxis.major_label_text_font_size = "0pt"
    levels = _levels(figures)
    return below_one_another([*plots, levels] if levels else plots)


def _levels(figures: Sequence[SensorFigures]) -> figure | None:
    """Levels of the accelerations in one-third-octave bands; None without any."""
    plot = figure(x_axis_type="log", height=300, tools="")
    number = 0
    for each in figures:
        bands = each.bands() if each.unit == "m/s^2" else None
        if bands is None:
            continue
        levels = np.maximum(bands.levels(reference_of(each.unit)), -100.0)
        for name, level in zip(each.shown, levels.T, strict=True):
            colour = COLOURS[number % len(COLOURS)]
            plot.step(bands.middle, level, mode="center", color=colour, legend_label=f"{each.topic} {name}")
            number += 1
    if not number:
        return None
    plot.xaxis.axis_label, plot.yaxis.axis_label = "one-third-octave band (Hz)", "level (dB re 1e-6 m/s²)"
    legend = plot.legend[0]
    legend.update(orientation="horizontal", click_policy="hide", border_line_alpha=0.0, background_fill_alpha=0.0)
    plot.add_layout(legend, "above")
    finish(plot)
    return zoomable(plot)


def _unit(of: SensorFigures) -> str:
    return of.unit.replace("^2", "²")
