"""Plots of the page, as Bokeh models: zoom and pan, one time axis for all that runs over time."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import (
    BoxZoomTool,
    ColorBar,
    ColumnDataSource,
    CustomJS,
    GlyphRenderer,
    HoverTool,
    Label,
    Legend,
    LegendItem,
    LinearColorMapper,
    PanTool,
    Range1d,
    ResetTool,
    SaveTool,
    Span,
    Title,
    WheelZoomTool,
    ZoomInTool,
    ZoomOutTool,
)
from bokeh.models.layouts import LayoutDOM
from bokeh.palettes import Inferno256
from bokeh.plotting import figure
from numpy.typing import NDArray

from .contact_map import ContactMap
from .envelope import drawn
from .figures import NEAR
from .files import asset
from .samples import WHEELS
from .spectrum import Spectrum
from .survey import Survey
from .table import force_lines, made_by

COLOURS = ("#e0641f", "#3b8ed0", "#1f9e77", "#cc79a7", "#b8860b", "#7a6fd0")
"""Told apart on light and dark ground, and with every kind of colour vision."""
MARK: Any = {"line_color": "#8c8c94", "line_width": 1, "line_dash": [4, 3]}
NOTE_HEIGHT = 60
"""Of the small print and of the axis above it, pixels."""
PADDING = 0.06
"""Space above and below curves, as a share of their range."""
MOST_CHANGES = 100
"""Most changes of the run that are marked in the plots."""


def time_plots(run: Survey) -> LayoutDOM:
    """Forces of both wheels and the stress of each node over time; the speed, too, if it changes."""
    found = drawn(run.bins, [closeup.samples for closeup in run.closeups])
    names = (*(f"wheel {wheel + 1}" for wheel in range(WHEELS)), *run.nodes)
    units = np.array([1e3] * WHEELS + [1e6] * len(run.nodes))
    columns: dict[str, NDArray[Any]] = {"time": found.time}
    for number in range(len(names)):
        for limit, values in (("low", found.low), ("high", found.high)):
            columns[f"{limit}{number}"] = (values[:, number] / units[number]).astype(np.float32)
    samples = ColumnDataSource(columns)
    end = run.end
    extremes = {
        f"value{number}": np.array([np.nanmin(columns[f"low{number}"]), np.nanmax(columns[f"high{number}"])])
        for number in range(len(names))
    }
    shown = ColumnDataSource({"time": np.array([run.start, end])} | extremes, name="shown")
    time = Range1d(run.start, end, bounds=(run.start, end), min_interval=1e-3, name="time")

    def spread(number: int) -> float:
        return float(np.ptp(extremes[f"value{number}"]))

    forces = over_an_axis("contact force (kN)", time, 320)
    widest_first = sorted(range(WHEELS), key=spread, reverse=True)  # a narrow curve is seen on a wide one
    curves(forces, shown, range(WHEELS), names, "kN", order=widest_first)
    _draw_limits(forces, run, time)
    _mark_impacts(forces, run)
    plots = [forces]
    stresses = range(WHEELS, len(names))
    least = min((extremes[f"value{number}"][0] for number in stresses), default=0.0)
    most = max((extremes[f"value{number}"][1] for number in stresses), default=1.0)
    margin = PADDING * (most - least)
    same = Range1d(least - margin, most + margin)  # a panel each, to compare: in one, curves would hide one another
    for number in stresses:
        stress = over_an_axis(f"stress {names[number]} (MPa)", time, 170)
        stress.y_range = same
        line = _curve(stress, shown, number, names[number], COLOURS[(number - WHEELS) % len(COLOURS)], "time")
        _read_out(stress, line, [(names[number], f"@value{number}{{0.0}} MPa")], "time")
        plots.append(stress)
    if len(run.speeds) > 1:
        speed = over_an_axis("speed (km/h)", time, 180)
        since, speeds = zip(*run.speeds, strict=True)
        speed.step(
            [*since, end],
            [3.6 * value for value in (*speeds, speeds[-1])],
            mode="after",
            color=COLOURS[3],
            line_width=2,
        )
        plots.append(speed)
    for plot in plots:
        for state in [state for state in run.states if state.revision][:MOST_CHANGES]:
            plot.add_layout(Span(location=state.time, dimension="height", **MARK))
    plots[-1].xaxis.axis_label = "simulated time (s)"
    _add_note(plots[-1], run)
    for plot in plots[:-1]:
        plot.xaxis.major_label_text_font_size = "0pt"
    refine = CustomJS(
        args={"samples": samples, "size": run.bins.size, "shown": shown, "range": time, "plot": forces},
        code=asset("decimate.js"),
    )
    time.js_on_change("start", refine)
    time.js_on_change("end", refine)
    forces.js_on_change("inner_width", refine)
    return below_one_another(plots)


def spectrum_plots(run: Survey, spectrum: Spectrum, marks: Iterable[tuple[float, str]]) -> LayoutDOM:
    """Power spectral densities of forces and stresses; ``marks`` are known frequencies, Hz."""
    keep = slice(1, None)
    frequency = spectrum.frequency[keep]
    density = spectrum.density[keep] / ([1e6] * WHEELS + [1e12] * len(run.nodes))
    names = (*(f"wheel {wheel + 1}" for wheel in range(WHEELS)), *run.nodes)
    source = ColumnDataSource(
        {"frequency": frequency.astype(np.float32)}
        | {f"value{number}": np.maximum(column, 1e-30).astype(np.float32) for number, column in enumerate(density.T)}
    )
    shared = Range1d(frequency[0], frequency[-1], bounds=(frequency[0], frequency[-1]), name="frequency")
    plots = []
    for title, unit, part in (
        ("contact force (kN²/Hz)", "kN²/Hz", range(WHEELS)),
        ("max. principal stress (MPa²/Hz)", "MPa²/Hz", range(WHEELS, len(names))),
    ):
        if not part:
            continue
        high = float(density[:, part].max())
        plot = figure(
            x_axis_type="log",
            y_axis_type="log",
            x_range=shared,
            y_range=Range1d(3e-9 * high, 3 * high),
            height=300,
            tools="",
        )
        plot.yaxis.axis_label = title
        curves(plot, source, part, names, unit, x="frequency", digits="0.00e+0")
        for number, (at, name) in enumerate(marks):
            plot.add_layout(Span(location=at, dimension="height", **MARK))
            text: Any = {"text_font_size": "11px", "x_offset": 3, "y_units": "screen"}
            plot.add_layout(Label(x=at, y=6 + 15 * number, text=f"{name} {at:.3g} Hz", **text))
        finish(plot)
        plots.append(zoomable(plot))
    plots[-1].xaxis.axis_label = "frequency (Hz)"
    _add_note(plots[-1], run)
    return below_one_another(plots)


def pressure_plot(run: Survey, contact: ContactMap) -> figure:
    """Contact pressure over the elements of the contact, and the rims of the defects there; axes in mm."""
    pressure = contact.pressure / 1e6
    colours = LinearColorMapper(
        palette=Inferno256[40:250], low=0.0, high=max(float(pressure.max()), 1.0), nan_color="rgba(0,0,0,0)"
    )
    x, y = (1e3 * axis for axis in (contact.x, contact.y))
    plot = figure(
        height=360,
        sizing_mode="stretch_width",
        toolbar_location=None,
        match_aspect=True,
        x_axis_label="along the track, ahead positive (mm)",
        y_axis_label="from the middle of the rail, to the left (mm)",
        tools="",
    )
    shown = np.where(pressure > 0, pressure, np.nan).T
    step_x, step_y = x[1] - x[0], y[1] - y[0]
    image = plot.image(
        image=[shown.astype(np.float32)],
        x=x[0] - step_x / 2,
        y=y[0] - step_y / 2,
        dw=len(x) * step_x,
        dh=len(y) * step_y,
        color_mapper=colours,
    )
    plot.add_tools(
        HoverTool(renderers=[image], tooltips=[("pressure", "@image{0} MPa"), ("x", "$x{0.0} mm"), ("y", "$y{0.0} mm")])
    )
    angle = np.linspace(0, 2 * np.pi, 181)
    for ahead, defect in contact.defects:
        rim_x, rim_y = (
            1e3 * (ahead + defect.a * np.cos(angle)),
            1e3 * (contact.rolling_circle + defect.y + defect.b * np.sin(angle)),
        )
        plot.line(rim_x, rim_y, line_color="#8c8c94", line_dash=[4, 3])
    plot.add_layout(
        ColorBar(color_mapper=colours, title="contact pressure (MPa)", width=12, background_fill_alpha=0.0), "right"
    )
    finish(plot)
    _add_note(plot, run)
    return plot


def over_an_axis(title: str, axis: Range1d, height: int) -> figure:
    """Empty plot over an axis that others may share."""
    plot = figure(x_range=axis, height=height, tools="")
    plot.yaxis.axis_label = title
    plot.y_range.range_padding = PADDING
    finish(plot)
    return zoomable(plot)


def below_one_another(plots: list[figure]) -> LayoutDOM:
    """Plots with one toolbar for all."""
    rows = [[plot] for plot in plots]
    grid: LayoutDOM = gridplot(rows, sizing_mode="stretch_width", merge_tools=True, toolbar_options={"logo": None})
    return grid


def curves(
    plot: figure,
    source: ColumnDataSource,
    part: Sequence[int],
    names: Sequence[str],
    unit: str,
    *,
    x: str = "time",
    digits: str = "0.0",
    order: Sequence[int] | None = None,
) -> None:
    """One curve a column, with a legend and a readout of all values wherever the mouse is.

    The first curve is drawn last and lies on top, unless ``order`` says in which order curves are drawn.
    """
    colours = dict(zip(part, itertools.cycle(COLOURS), strict=False))
    lines = {number: _curve(plot, source, number, names[number], colours[number], x) for number in order or part[::-1]}
    values = [(names[number], f"@value{number}{{{digits}}} {unit}") for number in part]
    _read_out(plot, lines[part[0]], values, x)
    items = [LegendItem(label=names[number], renderers=[lines[number]]) for number in part]
    legend = Legend(items=items, orientation="horizontal", click_policy="hide", border_line_alpha=0.0)
    legend.update(background_fill_alpha=0.0, padding=0, margin=2, spacing=10)
    plot.add_layout(legend, "above")


def _curve(plot: figure, source: ColumnDataSource, number: int, name: str, colour: str, x: str) -> GlyphRenderer:
    line: GlyphRenderer = plot.line(x, f"value{number}", source=source, color=colour, line_width=1.3, name=name)
    return line


def _read_out(plot: figure, line: GlyphRenderer, values: list[tuple[str, str]], x: str) -> None:
    """Say values of a line's source where the mouse is, above or below the line, too."""
    tips = [*values, ("time", "@time{0.0000} s") if x == "time" else ("frequency", "@frequency{0.0} Hz")]
    plot.add_tools(HoverTool(renderers=[line], tooltips=tips, mode="vline", line_policy="nearest", visible=False))


def _draw_limits(plot: figure, run: Survey, time: Range1d) -> None:
    """Lines at the static force, the threshold of impacts and the limit of the alarm, those that forces come near."""
    plot.y_range.renderers = [*plot.renderers]
    dashes: dict[str, list[int]] = {"static": [4, 3], "impact": [8, 4]}
    for name, force in force_lines(run).items():
        if force <= NEAR * run.peak.force:  # none that is unknown, either
            line = plot.line(
                [time.start, time.end],
                [force / 1e3] * 2,
                line_color=MARK["line_color"],
                line_dash=dashes.get(name, []),
                name=name,
            )
            plot.legend[0].items.append(LegendItem(label=name, renderers=[line]))


def _add_note(plot: figure, run: Survey) -> None:
    """Small print below a plot, which a saved picture keeps."""
    text = made_by(run).replace(". ", ".\n", 1)
    plot.height += NOTE_HEIGHT
    plot.add_layout(Title(text=text, text_font_size="10px", text_font_style="normal", name="note"), "below")


def _mark_impacts(plot: figure, run: Survey) -> None:
    """Marks at the peaks of the impacts."""
    if not run.impacts:
        return
    source = ColumnDataSource(
        {
            "time": [impact.time for impact in run.impacts],
            "force": [impact.peak_force / 1e3 for impact in run.impacts],
            "colour": [COLOURS[impact.wheel] for impact in run.impacts],
        },
        name="impacts",
    )
    plot.scatter("time", "force", source=source, marker="circle", size=6, line_color=None, fill_color="colour")


def finish(plot: figure) -> None:
    """What all plots have in common."""
    plot.background_fill_alpha = plot.border_fill_alpha = 0.0
    plot.outline_line_color = None
    plot.min_border_right = 8
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.minor_tick_line_color = None


def zoomable(plot: figure) -> figure:
    """With tools that move the horizontal axis, and that keep a picture."""
    box, wheel = BoxZoomTool(dimensions="width"), WheelZoomTool(dimensions="width", modifiers="ctrl")
    plot.add_tools(
        box,
        PanTool(dimensions="width"),
        ZoomInTool(dimensions="width"),
        ZoomOutTool(dimensions="width"),
        wheel,
        ResetTool(),
        SaveTool(),
    )
    plot.toolbar.active_drag, plot.toolbar.active_scroll = box, wheel
    return plot
