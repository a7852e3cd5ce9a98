"""The page itself: controls with their meanings, readouts and places for the plots."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any

from bokeh.embed import json_item

from ..report.files import STYLE
from ..report.plots import COLOURS
from ..version import __version__
from .background import QUANTITIES
from .downloads import FORMS
from .plots import EXAGGERATED, PIN_COLOURS, all_plots
from .view import KINDS, MEANINGS, SLIDERS, STRESSES, Base, View

FORCE_SOURCES = "200 kN counts as an impact in this software: about twice the static load of the shipped scenarios."
STRESS_SOURCES = (
    "A design by EN 13103-1 admits an amplitude of 166 MPa on the body of a solid axle of steel EA1N, whose fatigue "
    "limit in rotating bending is 200 MPa."
)
PASSAGE = (
    "The wheel makes one turn after an undamaged run, so a stress that the turn before has left is not in the curves; "
    "the damage of the axle is counted over a whole run."
)
READOUTS = (
    ("wheel_1-peak", "peak, wheel 1", "Largest contact force of wheel 1 over one turn."),
    ("wheel_2-peak", "peak, wheel 2", "Largest contact force of wheel 2 over one turn."),
    ("loss", "contact lost", "Time without contact of the damaged wheel over one turn."),
    ("amplitude", "bending amplitude", "Half the range of the axial stress of the worst point of the turning axle."),
)


def asset(name: str) -> str:
    """Text of a file beside this one."""
    return (files(__package__) / name).read_text(encoding="utf-8")


def style() -> str:
    """Style sheet: the look of reports, and what the page adds."""
    return STYLE + asset("explore.css")


def page(base: Base, view: View, pins: Sequence[str] = (), mapped: str = "", refused: str = "") -> str:
    """HTML of the page.

    Parameters
    ----------
    base, view
        The scenario, and what the controls say.
    pins
        Pinned views, as queries.
    mapped
        Both sliders and the quantity of a map, with colons between them; empty for none.
    refused
        Why the address could not be used, in one line.
    """
    settings = _json(
        {"colours": COLOURS, "pinColours": PIN_COLOURS, "exaggerated": EXAGGERATED, "pins": [*pins], "map": mapped}
    )
    name = escape(base.scenario.name)
    notes = "".join(f"<p class='quiet'>{escape(note)}.</p>" for note in base.notes)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="referrer" content="no-referrer">
<title>{name}: explore wheel damage</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="static/explore.css">
</head>
<body class="explore">
<header>
<h1>{name}</h1>
<dl id="readouts">{"".join(_readouts())}</dl>
<p id="status" role="status">{escape(refused) or "connecting"}</p>
</header>
<main>
<div id="side">
<form id="controls" aria-label="controls" autocomplete="off" novalidate>
{"".join(_controls(base, view))}
{notes}
</form>
<section id="verdict" aria-labelledby="verdict-title">
<h2 id="verdict-title">Verdict</h2>
<ul id="verdicts"></ul>
<p id="scatter"></p>
<p id="fatigue"></p>
</section>
{"".join(_keep())}
</div>
<div id="results">
<section aria-labelledby="forces-title">
<h2 id="forces-title">Contact force <span class="key"><i style="--colour:{COLOURS[0]}"></i>wheel 1
<i style="--colour:{COLOURS[1]}"></i>wheel 2</span></h2>
<div class="plot" id="forces" role="img" aria-label="contact force of both wheels along the track"></div>
</section>
<section aria-labelledby="stresses-title">
<h2 id="stresses-title">Axle stress <span id="stress-words"></span> <span class="key" id="nodes"></span></h2>
<div class="plot" id="stresses" role="img" aria-label="axial stress along the track"></div>
</section>
<div id="moment-row">
<label for="moment"><strong>Moment</strong> <span id="moment-words"></span></label>
<span id="pressure-words" class="quiet"></span>
<input type="range" id="moment" min="0" max="1" value="0" aria-describedby="moment-tip">
<span role="tooltip" id="moment-tip">Place in the turn whose contact is shown below. The mouse over a plot moves it, and
so do the arrow keys here. A new answer goes to its largest force.</span>
</div>
<div class="beside">
<section aria-labelledby="bodies-title">
<h2 id="bodies-title">Wheel on rail <span class="quiet">heights {EXAGGERATED} times the scale of lengths</span></h2>
<div class="plot" id="bodies" role="img" aria-label="profiles of wheel and rail along the track"></div>
</section>
<section aria-labelledby="pressure-title">
<h2 id="pressure-title">Contact pressure</h2>
<div class="plot" id="pressure" role="img" aria-label="map of the contact pressure, seen from above"></div>
</section>
</div>
<section aria-labelledby="map-title" id="map-section">
<h2 id="map-title">Map <span class="quiet" id="map-words">of a result over two sliders</span></h2>
<div class="row">{_choice("map-quantity", "show", QUANTITIES)}
{_choice("map-x", "over", {})}{_choice("map-y", "and", {})}
<button type="button" id="map-fill">Fill</button></div>
<div class="plot" id="map" role="img" aria-label="map of the result over both sliders" hidden></div>
</section>
<p class="quiet">{FORCE_SOURCES} <span id="sources"></span> {STRESS_SOURCES} <span id="fatigue-source"></span>
{PASSAGE}</p>
<p class="quiet">wheelset_track_sim {__version__}. An answer: <span id="seconds">none yet</span>.</p>
</div>
</main>
<noscript><p>This page needs JavaScript.</p></noscript>
<script type="application/json" id="plots">{_plots()}</script>
<script type="application/json" id="settings">{settings}</script>
<script src="static/bokeh.js"></script>
<script src="static/explore.js"></script>
</body>
</html>
"""


@cache
def _plots() -> str:
    plots = {name: json_item(plot, name) for name, plot in all_plots().items()}
    return _json(plots)


def _json(data: Any) -> str:
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")


def _readouts() -> Iterator[str]:
    for name, label, meaning in READOUTS:
        note = f"<span class='quiet' id='{name}-note'></span>"
        yield f'<div title="{escape(meaning)}"><dt>{label}</dt><dd><output id="{name}">–</output> {note}</dd></div>'


def _controls(base: Base, view: View) -> Iterator[str]:
    shown = view.shown()
    yield "<fieldset><legend>Damage</legend>"
    yield _select("kind", "kind", dict(KINDS), shown)
    yield _select("on", "wheel", {"wheel_1": "wheel 1", "wheel_2": "wheel 2"}, shown)
    for name in ("length", "width", "depth", "flat", "worn", "order", "amplitude", "place"):
        yield _slider(name, shown)
    yield "</fieldset><fieldset><legend>Run</legend>"
    yield _slider("speed", shown)
    yield _slider("load", shown)
    yield _select("wheelset", "wheelset", {name: name for name in base.wheelsets}, shown)
    yield _select("track", "track", {name: name for name in base.tracks}, shown)
    yield _select("rough", "treads", {"0": "smooth", "1": "rough"}, shown)
    yield _slider("level", shown)
    yield "</fieldset><fieldset><legend>Show</legend>"
    yield _select("limits", "limits", {name: name.replace("_", " ") for name in base.limits}, shown)
    yield _select("stress", "axle stress", dict(STRESSES), shown)
    yield "</fieldset>"


def _keep() -> Iterator[str]:
    yield '<div id="keep" role="group" aria-labelledby="keep-title"><h2 id="keep-title">Keep</h2>'
    yield """<div class="control choice"><span id="pin-label">curves</span>
<button type="button" id="pin" aria-describedby="pin-tip">Pin for comparison</button>
<span role="tooltip" id="pin-tip">Keeps the force of the damaged wheel and the stress of the worst node as dashed
curves. The address keeps them, too.</span></div><ol id="pins"></ol>"""
    files = "".join(f'<button type="button" data-suffix="{suffix}">{text}</button>' for suffix, text in FORMS.items())
    yield f"""<div class="control choice files"><span>files</span><div>{files}</div>
<span role="tooltip">The scenario as a file, or one turn of its wheel as run and report make it.</span></div>"""
    yield """<div class="control choice"><label for="measured">measured</label><input type="file" id="measured"
 accept=".csv,.txt,text/*" aria-describedby="measured-tip">
<span role="tooltip" id="measured-tip">Text file with the force of a wheel over time or position, as compare reads it;
or drop it anywhere on the page. It stays on this machine.</span></div><p id="measured-words"></p>"""
    yield "</div>"


def _choice(name: str, label: str, choices: Mapping[str, str]) -> str:
    options = "".join(f'<option value="{value}">{text}</option>' for value, text in choices.items())
    return f'<label>{label} <select id="{name}">{options}</select></label>'


def _slider(name: str, shown: Mapping[str, str]) -> str:
    of = SLIDERS[name]
    limits = f'min="{of.low:g}" max="{of.high:g}" step="{of.step:g}" value="{shown[name]}"'
    unit = f'<span class="unit">{of.unit}</span>'
    kinds = f' data-kinds="{" ".join(of.kinds)}"' if of.kinds else ""
    span = f"{of.low:g} to {of.high:g} {of.unit}".rstrip()
    return f"""<div class="control"{kinds} data-control="{name}">
<label for="{name}">{of.label}</label>
<input type="range" id="{name}-slider" {limits} aria-label="{of.label}" aria-describedby="{name}-tip">
<input type="number" id="{name}" name="{name}" {limits.replace(f'step="{of.step:g}"', 'step="any"')}
 inputmode="decimal" aria-describedby="{name}-tip">{unit}
<span role="tooltip" id="{name}-tip">{escape(of.meaning)} {span}.</span>
</div>
"""


def _select(name: str, label: str, choices: Mapping[str, str], shown: Mapping[str, str]) -> str:
    options = "".join(
        f'<option value="{escape(value)}"{" selected" if value == shown[name] else ""}>{escape(text)}</option>'
        for value, text in choices.items()
    )
    return f"""<div class="control choice" data-control="{name}">
<label for="{name}">{label}</label>
<select id="{name}" name="{name}" aria-describedby="{name}-tip">{options}</select>
<span role="tooltip" id="{name}-tip">{escape(MEANINGS[name])}</span>
</div>
"""
