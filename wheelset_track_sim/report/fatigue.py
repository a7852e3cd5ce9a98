"""Fatigue of the axle in the page of a run: damage over the angle and the distance, and the matrix of its cycles."""

from __future__ import annotations

import math
from html import escape

import numpy as np
from bokeh.layouts import column
from bokeh.models import ColorBar, ColumnDataSource, HoverTool, LinearColorMapper
from bokeh.models.layouts import LayoutDOM
from bokeh.palettes import Inferno256
from bokeh.plotting import figure

from ..fatigue.axle import AxleFatigue, NodeFatigue
from ..fatigue.rainflow_kernels import MEAN_WIDTH, MEANS, RANGE_WIDTH
from .plots import COLOURS, MARK, finish

AROUND = np.linspace(0, 2 * np.pi, 181)
RULES = {"haibach": "Haibach", "curve": "second slope"}
LARGEST = 560
"""Width of the polar plot, pixels."""


def section(found: AxleFatigue, plot: str) -> str:
    """Table and plots of the fatigue; every number that depends on the S-N curve says so."""
    nodes, curve = found.nodes, found.curve
    head = (
        "<th>node</th><th>* damage, ratio to undamaged</th><th>rotating amplitude</th><th>undamaged</th>"
        "<th>worst angle</th>"
        + "".join(f"<th>* damage per 1,000 km, {RULES.get(rule, rule)}</th>" for rule in curve.rules)
    )
    lines = "".join(
        f"<tr><td>{escape(node.name)}</td><td>{node.ratios[0]:.2f}</td><td>{node.amplitude / 1e6:.1f} MPa</td>"
        f"<td>{node.undamaged_amplitude / 1e6:.1f} MPa</td><td>{math.degrees(node.angle):.0f}°</td>"
        + "".join(f"<td>{damage:.3g}</td>" for damage in node.damage_in(1e6))
        + "</tr>"
        for node in nodes
    )
    assumed = " <strong>These constants are assumed.</strong>" if curve.assumed else ""
    worst = _most_damaged(nodes)
    return (
        '<h2 id="fatigue">Fatigue of the turning axle</h2><div class="list"><table id="fatigue-nodes">'
        f"<thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table></div>{plot}"
        f'<p class="quiet">* by the S-N curve {escape(curve.name)}: {curve.limit / 1e6:.4g} MPa at '
        f"{curve.knee_cycles:g} cycles, slope {curve.slope:g}, survival {curve.survival_probability:g}; source: "
        f"{escape(curve.source)}.{assumed} Top: damage of each point around the axle by the elementary rule, over that "
        "without damaged wheels, which is the circle; angle 0 is at the top when angle 0 of the treads meets the rail. "
        "Middle: the same damage, summed over the distance, at the worst angle; dashed without damaged wheels. Bottom: "
        f"cycles of {escape(worst.name)} at its worst angle.</p>"
    )


def fatigue_plots(found: AxleFatigue) -> LayoutDOM:
    """Damage over the angle, over the distance, and the range-mean matrix of the most damaged node."""
    plots = _polar(found), _over_distance(found), _matrix(found)
    layout: LayoutDOM = column(*plots, sizing_mode="stretch_width")
    return layout


def _most_damaged(nodes: tuple[NodeFatigue, ...]) -> NodeFatigue:
    return max(nodes, key=lambda node: float(node.damage[:, 0].max()))


def _polar(found: AxleFatigue) -> figure:
    """Ratio to the undamaged axle over the angle."""
    most = max(node.ratios[0] for node in found.nodes)
    rings = np.arange(1, math.ceil(most) + 1)
    plot = figure(
        height=420,
        width=LARGEST,
        match_aspect=True,
        toolbar_location=None,
        tools="",
        title="damage over that without damaged wheels, by angle",
    )
    plot.axis.visible = False
    plot.grid.visible = False
    for ring in rings:
        width = 2 if ring == 1 else 1
        plot.line(ring * np.cos(AROUND), ring * np.sin(AROUND), **{**MARK, "line_width": width})
        plot.text([0], [ring], text=[f"{ring}"], text_font_size="11px", text_color=MARK["line_color"], x_offset=3)
    for number, node in enumerate(found.nodes):
        ratio = node.damage[:, 0] / node.undamaged[0]
        # Angle 0 is drawn at the top, and angles grow clockwise.
        angle = np.pi / 2 - np.append(node.angles, node.angles[0])
        radius = np.append(ratio, ratio[0])
        at = {"x": radius * np.cos(angle), "y": radius * np.sin(angle), "ratio": radius}
        at["angle"] = np.degrees(np.pi / 2 - angle)
        colour = COLOURS[number % len(COLOURS)]
        line = plot.line("x", "y", source=ColumnDataSource(at), color=colour, line_width=2, legend_label=node.name)
        plot.add_tools(HoverTool(renderers=[line], tooltips=[(node.name, "@ratio{0.00} at @angle{0}°")]))
    _legend(plot)
    return plot


def _over_distance(found: AxleFatigue) -> figure:
    """Damage at the worst angle over the distance."""
    distances, damage = found.marks
    size, unit = (1e3, "km") if distances.size and distances[-1] >= 1e4 else (1.0, "m")
    plot = figure(
        height=300,
        sizing_mode="stretch_width",
        toolbar_location=None,
        tools="",
        x_axis_label=f"distance ({unit})",
        y_axis_label="* damage, elementary rule",
    )
    for number, node in enumerate(found.nodes):
        colour = COLOURS[number % len(COLOURS)]
        summed = np.append(0.0, damage[:, number, node.worst, 0])
        at = np.append(0.0, distances) / size
        line = plot.line(at, summed, color=colour, line_width=2, legend_label=node.name)
        ends = [0.0, node.distance / size]
        plot.line(ends, [0.0, float(node.undamaged[0])], color=colour, line_dash=[4, 3])
        plot.add_tools(HoverTool(renderers=[line], tooltips=[(node.name, f"@y{{0.00e+0}} after @x{{0.0}} {unit}")]))
    _legend(plot)
    finish(plot)
    return plot


def _matrix(found: AxleFatigue) -> figure:
    """Cycles of the most damaged point by range and mean."""
    nodes = found.nodes
    node = _most_damaged(nodes)
    channel = nodes.index(node) * len(node.angles) + node.worst
    halves = found.spectrum.half_cycles[channel]
    rows, columns = np.nonzero(halves)
    top, low, high = rows.max(initial=0) + 1, columns.min(initial=MEANS), columns.max(initial=0) + 1
    shown = np.where(halves > 0, np.log10(np.maximum(halves, 1) / 2), np.nan)[:top, low:high].T
    largest = float(np.nanmax(shown, initial=0.0))
    colours = LinearColorMapper(
        palette=Inferno256[40:250], low=-0.31, high=max(largest, 0.1), nan_color="rgba(0,0,0,0)"
    )
    start = MEAN_WIDTH * (low - MEANS // 2) / 1e6
    plot = figure(
        height=300,
        sizing_mode="stretch_width",
        toolbar_location=None,
        tools="",
        x_axis_label=f"range of rotating stress at {node.name} (MPa)",
        y_axis_label="mean (MPa)",
    )
    image = plot.image(
        image=[shown.astype(np.float32)],
        x=0.0,
        y=start,
        dw=top * RANGE_WIDTH / 1e6,
        dh=(high - low) * MEAN_WIDTH / 1e6,
        color_mapper=colours,
    )
    tips = [("cycles", "10^@image{0.0}"), ("range", "$x{0} MPa"), ("mean", "$y{0} MPa")]
    plot.add_tools(HoverTool(renderers=[image], tooltips=tips))
    bar = ColorBar(color_mapper=colours, title="log10 of cycles", width=12, background_fill_alpha=0.0)
    plot.add_layout(bar, "right")
    finish(plot)
    return plot


def _legend(plot: figure) -> None:
    legend = plot.legend[0]
    legend.update(orientation="horizontal", click_policy="hide", border_line_alpha=0.0, background_fill_alpha=0.0)
    plot.add_layout(legend, "above")
