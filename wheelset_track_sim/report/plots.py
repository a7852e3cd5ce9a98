"""Plots of the page, as Bokeh models: zoom and pan, one time axis for all that runs over time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import (
    BoxZoomTool,
    ColorBar,
    ColumnDataSource,
    CustomJS,
    HoverTool,
    Label,
    LinearColorMapper,
    PanTool,
    Range1d,
    ResetTool,
    SaveTool,
    Span,
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
from .files import asset
from .samples import WHEELS
from .spectrum import Spectrum
from .survey import Survey

COLOURS = ("#e0641f", "#3b8ed0", "#1f9e77", "#cc79a7", "#b8860b", "#7a6fd0")
"""Told apart on light and dark ground, and with every kind of colour vision."""
MARK: Any = {"line_color": "#8c8c94", "line_width": 1, "line_dash": [4, 3]}
MOST_CHANGES = 100
"""Most changes of the run that are marked in the plots."""


def time_plots(run: Survey) -> LayoutDOM:
    """Forces of both wheels and the stress of every node over time; the speed, too, if it changes."""
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

    forces = over_an_axis("contact force (kN)", time, 320)
    curves(forces, shown, range(WHEELS), names, "kN")
    if not math.isnan(run.wheel_load):
        forces.add_layout(Span(location=run.wheel_load / 1e3, dimension="width", **MARK))
    _mark_impacts(forces, run)
    plots = [forces]
    if run.nodes:
        stresses = over_an_axis("max. principal stress (MPa)", time, 320)
        curves(stresses, shown, range(WHEELS, len(names)), names, "MPa")
        plots.append(stresses)
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
    return below_one_another(plots)


def pressure_plot(contact: ContactMap) -> figure:
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
    return plot


def over_an_axis(title: str, axis: Range1d, height: int) -> figure:
    """Empty plot over an axis that others may share."""
    plot = figure(x_range=axis, height=height, tools="")
    plot.yaxis.axis_label = title
    plot.y_range.range_padding = 0.06
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
) -> None:
    """One curve a column; the first is drawn last, so that the damaged wheel and the most stressed node lie on top."""
    for number in reversed(part):
        colour = COLOURS[(number - part[0]) % len(COLOURS)]
        name = names[number]
        line = plot.line(x, f"value{number}", source=source, color=colour, line_width=1.3, legend_label=name, name=name)
        where = ("time", "@time{0.0000} s") if x == "time" else ("frequency", "@frequency{0.0} Hz")
        tips = [(name, f"@value{number}{{{digits}}} {unit}"), where]
        plot.add_tools(HoverTool(renderers=[line], tooltips=tips, line_policy="nearest", visible=False))
    legend = plot.legend[0]
    legend.items.reverse()
    legend.update(orientation="horizontal", click_policy="hide", border_line_alpha=0.0, background_fill_alpha=0.0)
    legend.update(padding=0, margin=2, spacing=10)
    plot.add_layout(legend, "above")


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
