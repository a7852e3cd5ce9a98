"""A run as one HTML page that needs nothing else: no network, no other files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime, timezone
from html import escape
from pathlib import Path

from matplotlib.axes import Axes

from ..errors import InputError
from ..recording import Recording
from .figures import detail, draw_forces, draw_stresses, svg
from .table import Comparison, comparison, description, headings, rows, source

Draw = Callable[[Axes, Recording, slice], None]

WIDE, NARROW = (9.0, 3.3), (4.0, 3.1)
"""Size of a figure on a laptop and on a phone, inches: text stays legible on both."""

PAPER = (
    "M. Maglio, A. Pieringer, J. C. O. Nielsen, T. Vernersson, “Wheel–rail impact loads and axle bending stress "
    "simulated for generic distributions and shapes of discrete wheel tread damage”."
)

STYLE = """
:root { color-scheme: light; }
body { margin: 0 auto; max-width: 60rem; padding: 1.5rem 1rem 4rem; background: #fff; color: #1d1d1f;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.6rem; margin: 0 0 .25rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .5rem; }
p { margin: .25rem 0 .75rem; }
.quiet { color: #5a5a5f; font-size: .9rem; }
div.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .5rem; border-bottom: 1px solid #e3e3e6; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; white-space: normal; padding-left: 0; }
thead th { border-bottom: 2px solid #1d1d1f; font-weight: 600; }
tr.first td { border-top: 1px solid #8a8a8f; }
figure { margin: .5rem 0 1.25rem; }
figure svg { display: block; width: 100%; height: auto; }
figure .narrow { display: none; }
pre { overflow-x: auto; background: #f6f6f7; padding: .8rem 1rem; border-radius: .4rem;
  font-size: .85rem; line-height: 1.4; }
@media (max-width: 40rem) {
  body { padding: 1rem .75rem 3rem; font-size: 15px; }
  th, td { padding: .3rem .2rem; font-size: .78rem; }
  table.compared tr { display: grid; grid-template-columns: repeat(4, 1fr); border-bottom: 1px solid #e3e3e6; }
  table.compared th, table.compared td { border: 0; }
  table.compared :is(th, td):first-child { grid-column: 1 / -1; padding-bottom: 0; font-weight: 600; }
  figure .wide { display: none; }
  figure .narrow { display: block; }
}
@media print { body { max-width: none; } figure { break-inside: avoid; } }
"""


def write_report(recording: Recording, out: Path) -> Path:
    """Write the page of a run to ``out`` and return it; raises InputError if the path cannot be written."""
    name = escape(recording.info.scenario_name)
    page = f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}: wheel loads and axle stresses</title>
<style>{STYLE}</style>
</head>
<body>
<h1>{name}</h1>
<p>{escape(description(recording))}</p>
{"".join(_sections(recording))}
</body>
</html>
"""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(page, encoding="utf-8")
    except OSError as reason:
        raise InputError(f"{out} cannot be written ({reason.strerror}): give another path with --out") from None
    return out


def _sections(recording: Recording) -> Iterator[str]:
    compared = comparison(recording)
    yield _table(recording, compared)
    around, whole = detail(recording, compared), slice(0, len(recording))
    if around != whole:
        yield f"<h2>{'The passage that the paper prints' if compared else 'Around the largest contact force'}</h2>"
        yield _figure(recording, draw_forces, around, "Contact forces of both wheels")
        yield _figure(recording, draw_stresses, around, "Maximum principal stress at the nodes of the axle")
    yield "<h2>The whole run</h2>"
    yield _figure(recording, draw_forces, whole, "Contact forces over the whole run")
    yield _figure(recording, draw_stresses, whole, "Maximum principal stress over the whole run")
    yield _changes(recording)
    yield _origin(recording)


def _table(recording: Recording, compared: Comparison | None) -> str:
    titles = headings(compared)
    head = "".join(f"<th>{title}</th>" for title in ("", *titles))
    lines, unit = [], ""
    for row in rows(recording, compared):
        cells = (row.label, *row.cells()[: len(titles)])
        first = ' class="first"' if unit and row.unit != unit else ""
        lines.append(f"<tr{first}>{''.join(f'<td>{escape(cell)}</td>' for cell in cells)}</tr>")
        unit = row.unit
    note = f'<p class="quiet">{escape(source(compared))} {PAPER}</p>' if compared else ""
    kind = "compared" if compared else "alone"
    table = f'<table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table>'
    return f'<div class="scroll">{table}</div>{note}'


def _figure(recording: Recording, draw: Draw, part: slice, title: str) -> str:
    drawings = "".join(
        f'<div class="{kind}">{svg(recording, draw, part, *size, title)}</div>'
        for kind, size in (("wide", WIDE), ("narrow", NARROW))
    )
    return f"<figure>{drawings}</figure>"


def _changes(recording: Recording) -> str:
    if len(recording.states) < 2:
        return ""
    lines = "".join(
        f"<tr><td>{state.revision}</td><td>{state.first_step}</td><td>{state.time:.4f} s</td>"
        f"<td>{3.6 * state.speed:.4g} km/h</td><td>{len(state.damage)}</td></tr>"
        for state in recording.states
    )
    return (
        "<h2>Changes during the run</h2><table><thead><tr><th>revision</th><th>from step</th><th>time</th>"
        f"<th>speed</th><th>defects</th></tr></thead><tbody>{lines}</tbody></table>"
    )


def _origin(recording: Recording) -> str:
    info = recording.info
    start = datetime.fromtimestamp(recording.start_ns / 1e9, tz=timezone.utc)
    facts = [f"{name} {number}" for name, number in info.versions.items()]
    if recording.start_ns:
        facts.append(f"step 0 at {start:%Y-%m-%d %H:%M:%S} UTC")
    facts.append(f"digest {info.digest}")
    return (
        f'<h2>Scenario</h2><pre>{escape(info.scenario)}</pre><p class="quiet">Bag {escape(recording.path.name)}: '
        f"{escape(', '.join(facts))}.</p>"
    )
