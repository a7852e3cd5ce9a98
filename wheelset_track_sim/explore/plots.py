"""The plots of the page, empty: ``explore.js`` fills their sources when an answer comes."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColorBar, ColumnDataSource, HoverTool, Label, LinearColorMapper, Range1d, SaveTool, Span
from bokeh.palettes import Inferno256
from bokeh.plotting import figure

from ..report.plots import COLOURS, MARK, finish, over_an_axis

PINS = 4
"""Pinned answers that are drawn at most."""
PIN_COLOURS = ("#7a6fd0", "#b8860b", "#1f9e77", "#cc79a7")
NODES = 6
"""Stress nodes that are drawn at most."""
EXAGGERATED = 5
"""Heights of the bodies in contact are drawn at this many times the scale of lengths."""
LIMITS = 6
"""Contact forces that are marked at most: that of an impact, and the limits that the view names."""
SLEEPERS = 12
"""Sleepers that are marked at most; the first is two bays behind the origin."""
RAIL = "#8c8c94"


def all_plots() -> dict[str, figure]:
    """Plots by the name of the element that they are drawn in."""
    return {"forces": _forces(), "stresses": _stresses(), "bodies": _bodies(), "pressure": _pressure(), "map": _map()}


def _forces() -> figure:
    plot = _over_place("contact force (kN)", 225, Range1d(0.0, 400.0, name="force-range"))
    for number in range(LIMITS):
        plot.add_layout(Span(dimension="width", tags=["limit", number], **MARK | {"line_dash": [8, 4]}))
        text: Any = {"text_font_size": "11px", "text_baseline": "bottom", "x": 6, "x_units": "screen"}
        plot.add_layout(Label(y=0, text="", visible=False, tags=["limit", number], **text))
    return _with_curves(plot, "force", 2)


def _stresses() -> figure:
    plot = _over_place("axial stress (MPa)", 200, Range1d(-100.0, 100.0, name="stress-range"))
    plot.xaxis.axis_label = "position along the track, from a sleeper (m)"
    return _with_curves(plot, "stress", NODES)


def _over_place(title: str, height: int, over: Range1d) -> figure:
    plot = over_an_axis(title, Range1d(-0.9, 1.813, min_interval=0.01), height)
    plot.y_range = over
    plot.tools = [tool for tool in plot.tools if not isinstance(tool, SaveTool)]  # what it saves has no key of colours
    plot.toolbar.update(logo=None, autohide=True)
    plot.sizing_mode = "stretch_width"
    plot.min_border_left = 76  # so that both plots have the same axis
    for number in range(SLEEPERS):
        plot.add_layout(Span(dimension="height", line_alpha=0.3, tags=["sleeper", number - 2], **MARK))
    return plot


def _with_curves(plot: figure, kind: str, most: int) -> figure:
    """With sources for the curves of an answer and of those that are pinned, and a line at the moment shown."""
    for number in range(PINS):
        source = ColumnDataSource({"place": np.empty(0), "value": np.empty(0)}, name=f"{kind}-pin{number}")
        plot.line("place", "value", source=source, color=PIN_COLOURS[number], line_dash=[6, 3], line_width=1.1)
    measured = ColumnDataSource({"place": np.empty(0), "value": np.empty(0)}, name=f"{kind}-measured")
    plot.line("place", "value", source=measured, color=RAIL, line_width=2.5, line_alpha=0.8)
    names = [f"value{number}" for number in range(most)]
    source = ColumnDataSource({name: np.empty(0) for name in ("place", *names)}, name=f"{kind}-curves")
    for number in reversed(range(most)):  # the first lies on top
        plot.line("place", names[number], source=source, color=COLOURS[number], line_width=1.4)
    plot.add_layout(Span(dimension="height", line_color=RAIL, line_width=3, line_alpha=0.35, tags=["moment"]))
    return plot


def _bodies() -> figure:
    names = ("x", "rail", "wheel", "touched", "top", "bottom")
    source = ColumnDataSource({name: np.empty(0) for name in names}, name="bodies")
    plot = _of_contact("height (mm)", Range1d(-80, 80), Range1d(-3, 9, name="bodies-y"))
    plot.varea("x", "wheel", "top", source=source, fill_color=COLOURS[1], fill_alpha=0.35)
    plot.varea("x", "bottom", "rail", source=source, fill_color=RAIL, fill_alpha=0.4)
    plot.line("x", "wheel", source=source, color=COLOURS[1], line_width=1.5)
    plot.line("x", "rail", source=source, color=RAIL, line_width=1.5)
    plot.line("x", "touched", source=source, color=COLOURS[0], line_width=4)
    return plot


def _pressure() -> figure:
    colours = LinearColorMapper(
        palette=Inferno256[40:250], low=0.0, high=3000.0, nan_color="rgba(0,0,0,0)", name="pressure-colours"
    )
    nothing = {"image": [np.zeros((2, 2), np.float32)], "x": [0.0], "y": [0.0], "dw": [0.0], "dh": [0.0]}
    source = ColumnDataSource(nothing, name="pressure-map")
    plot = _of_contact("to the left (mm)", Range1d(-30, 30, name="pressure-x"), Range1d(-15, 15, name="pressure-y"))
    image = plot.image("image", "x", "y", "dw", "dh", source=source, color_mapper=colours)
    tips = [("pressure", "@image{0} MPa"), ("ahead", "$x{0.0} mm"), ("to the left", "$y{0.0} mm")]
    plot.add_tools(HoverTool(renderers=[image], tooltips=tips, visible=False))
    plot.add_layout(ColorBar(color_mapper=colours, title="MPa", width=12, background_fill_alpha=0.0), "right")
    return plot


def _map() -> figure:
    colours = LinearColorMapper(palette=Inferno256[40:250], low=0.0, high=1.0, nan_color="rgba(0,0,0,0)")
    colours.name = "map-colours"
    nothing = {"image": [np.full((2, 2), np.nan, np.float32)], "x": [0.0], "y": [0.0], "dw": [0.0], "dh": [0.0]}
    source = ColumnDataSource(nothing, name="map-cells")
    plot = _of_contact("", Range1d(0, 1, name="map-x"), Range1d(0, 1, name="map-y"))
    image = plot.image("image", "x", "y", "dw", "dh", source=source, color_mapper=colours)
    plot.add_tools(HoverTool(renderers=[image], tooltips=[("", "@image{0.0}")], visible=False))
    plot.scatter("x", "y", source=ColumnDataSource({"x": [], "y": []}, name="map-here"), size=10, color="#3b8ed0")
    plot.add_layout(ColorBar(color_mapper=colours, width=12, background_fill_alpha=0.0), "right")
    return plot


def _of_contact(title: str, x: Range1d, y: Range1d) -> figure:
    plot = figure(height=210, sizing_mode="stretch_width", toolbar_location=None, x_range=x, y_range=y, tools="")
    plot.xaxis.axis_label, plot.yaxis.axis_label = "ahead along the track (mm)", title
    finish(plot)
    return plot
