"""A run as one HTML page that needs nothing else: no network, no other files."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import escape
from pathlib import Path

from bokeh.embed import json_item
from bokeh.models.layouts import LayoutDOM
from bokeh.resources import Resources

from ..errors import ContactError, InputError
from ..fatigue.axle import AxleFatigue
from ..scenario import Scenario
from ..twin.measured import Comparison
from . import fatigue, measured, plots, sections, sensors
from .contact_map import ContactMap, contact_map
from .files import STYLE, asset, write_whole
from .survey import Survey
from .table import description, title

SECURITY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'unsafe-eval'; img-src data:"
"""The browser itself prevents all requests of the page."""


def write_report(
    run: Survey, out: Path, comparison: Comparison | None = None, counted: AxleFatigue | None = None
) -> Path:
    """Write the page of a run to ``out`` and return it.

    It has a section on what was measured if there is a comparison, and on fatigue if that was counted.

    Raises InputError if the path cannot be written.
    """
    name = escape(title(run))
    library = "".join(
        f"<script>{text}</script>\n" for text in Resources(mode="inline", components=["bokeh"], log_level="warn").js_raw
    )
    page = f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{SECURITY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}: wheel loads and axle stresses</title>
<link rel="icon" href="data:,">
<style>
{STYLE}</style>
</head>
<body>
<h1>{name}</h1>
<p>{escape(description(run))}</p>
{sections.surfaces(run)}
<noscript><p>The plots need JavaScript; the tables do not.</p></noscript>
{"".join(_sections(run, comparison, counted))}
{library}<script>
{asset("page.js")}</script>
</body>
</html>
"""
    return write_whole(out, page.encode(errors="backslashreplace"))


def _sections(run: Survey, comparison: Comparison | None, counted: AxleFatigue | None) -> Iterator[str]:
    yield sections.losses(run)
    yield sections.peaks(run)
    yield sections.verdict(run)
    yield sections.over_time(run, _plot(plots.time_plots(run), "time-plots"))
    yield sections.impacts(run)
    if run.sensors:
        yield sensors.section(run.sensors, _plot(sensors.sensor_plots(run.sensors, run.peak.time), "sensor-plots"))
    if counted:
        yield fatigue.section(counted, _plot(fatigue.fatigue_plots(counted), "fatigue-plots"))
    if comparison:
        yield measured.section(comparison, _plot(measured.measured_plots(comparison), "measured-plots"))
    scenario = run.scenario_in_force(run.peak.revision)
    found = _contact(run, scenario) if scenario else None
    if found:
        yield sections.pressure(run, found, _plot(plots.pressure_plot(run, found), "pressure-plot", "map"))
    if run.spectrum:
        marks = sections.known_frequencies(run, run.spectrum)
        yield sections.spectra(run.spectrum, _plot(plots.spectrum_plots(run, run.spectrum, marks), "spectrum-plots"))
    yield sections.what_ran(run)


def _contact(run: Survey, scenario: Scenario) -> ContactMap | None:
    """Contact at the largest force; None if the wheelset is in a file that is not here."""
    try:
        return contact_map(scenario, run.peak.wheel, run.peak.step, run.peak.force)
    except (ContactError, InputError):
        return None


def _plot(layout: LayoutDOM, name: str, kind: str = "") -> str:
    item = json.dumps(json_item(layout, name), separators=(",", ":")).replace("<", "\\u003c")
    return f'<div class="plot {kind}" id="{name}"></div><script type="application/json" data-plot>{item}</script>'
