"""Sections of the page: headings, words and tables around the plots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from html import escape
from typing import Any

from ..contact.hardness import flag
from ..irregularities.description import description_of
from ..monitoring.limits import Limits
from ..samples.impacts import Impact
from .contact_map import ContactMap
from .files import PAPER
from .spectrum import Spectrum
from .survey import InForce, Survey
from .table import between, force_lines, headings, rows, source, verdict_words

VIEW = 0.010, 0.030
"""Time shown before and after an impact, s."""
AMPLITUDE = (
    "Bending amplitude: half the range of bending stress that a point of the turning axle goes through, in the turn "
    "with the largest. Fatigue limits refer to it; by default, diagnostics warn above {} and raise an alarm above {}."
)
STRESS_LIMITS = (
    "A limit of axle stress is compared with the bending amplitude of the turning axle, never with the largest "
    "principal stress. "
)
MOST_IMPACTS = 100
"""Most impacts that are listed."""
MOST_LOSSES = 50
"""Most losses that are listed."""
MOST_STATES = 200
"""Most revisions that are listed."""


def peaks(run: Survey) -> str:
    """Table of maxima and minima, beside the paper's if it prints the case."""
    titles = headings(run)
    head = "".join(f"<th>{title}</th>" for title in ("", *titles))
    lines, unit = [], ""
    for row in rows(run):
        cells = (
            f'<td data-name="{title}">{escape(cell)}</td>' for title, cell in zip(titles, row.cells(), strict=False)
        )
        first = ' class="first"' if unit and row.unit != unit else ""
        lines.append(f"<tr{first}><td>{escape(row.label)}</td>{''.join(cells)}</tr>")
        unit = row.unit
    notes = [f"{escape(source(run.passage))} {PAPER}"] if run.passage else []
    if not all(map(math.isnan, run.amplitudes)):
        limits = (f"{limit / 1e6:g} MPa" for limit in (Limits().stress_warn, Limits().stress_error))
        notes.append(AMPLITUDE.format(*limits))
    note = "".join(f'<p class="quiet">{text}</p>' for text in notes)
    kind = "compared" if run.passage else "alone"
    table = f'<table class="{kind}"><thead><tr>{head}</tr></thead><tbody>{"".join(lines)}</tbody></table>'
    return f"<h2>Peaks</h2>{table}{note}"


def verdict(run: Survey) -> str:
    """What the run reached against the limits, comparison by comparison; nothing without limits."""
    if run.limits is None:
        return ""
    found = run.verdicts
    head = '<th>level</th><th class="text">compared</th><th class="text">source of the limit</th>'
    lines = "".join(
        f"<tr><td>{each.level.word}</td><td class='text'>{escape(each.text)}</td>"
        f"<td class='text quiet'>{escape(each.limit.source)}</td></tr>"
        for each in found
    )
    table = f'<table id="verdicts"><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>' if found else ""
    return (
        f'<h2>Verdict: <span id="verdict">{verdict_words(run)}</span></h2><div class="list">{table}</div>'
        f'<p class="quiet">Forces act at the contact; a wayside detector reads others. '
        f"{STRESS_LIMITS if run.nodes else ''}What the set has no limit for is not compared.</p>"
    )


def losses(run: Survey) -> str:
    """What of the bag is damaged or missing; nothing if it is whole."""
    if not run.losses:
        return ""
    listed = "".join(f"<li>{escape(str(loss))}</li>" for loss in run.losses[:MOST_LOSSES])
    more = len(run.losses) - MOST_LOSSES
    rest = f"<li>and {more} more, which info lists</li>" if more > 0 else ""
    return (
        "<h2>This bag is not whole</h2><p>All figures are of what can be read of it. Missing or damaged are:</p>"
        f"<ul>{listed}{rest}</ul>"
    )


def over_time(run: Survey, plot: str) -> str:
    """Plots over time, with buttons that move the time axis, and what is drawn."""
    buttons = f"{_button('Whole run', run.start, run.end)} {_button('Largest force', *_around(run.peak.time))}"
    bins = run.bins
    if bins.size == 1:
        drawn = "Every step is drawn."
    else:
        dx = run.distance / run.steps
        drawn = (
            f"Drawn are the smallest and the largest value of each {bins.size} steps ({1e3 * bins.size * dx:.4g} mm), "
            f"so that no peak is lost, and every step within about one turn of the wheel around the "
            f"{len(run.closeups)} largest forces."
        )
    marked = force_lines(run).items()
    known = ", ".join(name if name.endswith(" kN") else f"{name} {force / 1e3:.4g} kN" for name, force in marked)
    lines = f"Lines: {escape(known)}, as far as forces reach them. " if known else ""
    stress = "Stress is the maximum principal stress. " if run.nodes else ""
    return (
        f'<h2 id="over-time">Forces and stresses over time</h2><p class="screen">{buttons}</p>{plot}'
        f'<p class="quiet">{drawn} {lines}{stress}Drag to zoom into a time, or turn '
        "the mouse wheel with the Ctrl key; a finger pans, two zoom. All plots show the same time.</p>"
    )


def impacts(run: Survey) -> str:
    """List of impacts, the strongest if there are many, in the order of their time."""
    heading = "<h2>Impacts</h2>"
    if math.isnan(run.threshold):
        return f"{heading}<p>The wheelset of this bag is not known here, so impacts are not looked for.</p>"
    above = f"a contact force above {run.threshold / 1e3:.4g} kN"
    if not run.impacts:
        return f"{heading}<p>There is no impact: at no time was there {above}.</p>"
    number = f"{len(run.impacts)} impacts, each" if len(run.impacts) > 1 else "1 impact,"
    words = f"{number} {above}."
    listed: Sequence[Impact] = run.impacts
    if len(listed) > MOST_IMPACTS:
        strongest = sorted(listed, key=lambda impact: -impact.peak_force)[:MOST_IMPACTS]
        listed = sorted(strongest, key=lambda impact: impact.step)
        words += f" The {MOST_IMPACTS} strongest are listed."
    head = (
        '<th>time</th><th>wheel</th><th>peak</th><th>dynamic factor</th><th class="wide">position</th>'
        '<th>angle on the wheel</th><th>without contact before</th><th class="wide">speed</th>'
    )
    lines = "".join(
        f"<tr><td>{_button(f'{impact.time:.4f} s', *_around(impact.time))}</td><td>{impact.wheel + 1}</td>"
        f"<td>{impact.peak_force / 1e3:.1f} kN</td><td>{impact.dynamic_factor:.2f}</td>"
        f'<td class="wide">{impact.position:.3f} m</td><td>{math.degrees(impact.angle):.1f}°</td>'
        f'<td>{1e3 * impact.contact_loss:.2f} ms</td><td class="wide">{3.6 * impact.speed:.4g} km/h</td></tr>'
        for impact in listed
    )
    return (
        f'{heading}<p>{words}</p><div class="list"><table id="impacts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{lines}</tbody></table></div>"
    )


def pressure(run: Survey, contact: ContactMap, plot: str) -> str:
    """Map of the contact pressure at the largest force."""
    peak = run.peak
    x, y = (1e3 * length for length in contact.size)
    rim = " Dashed: rim of the defect." if contact.defects else ""
    flagged = flag(contact.pressure, contact.bound)
    beyond = f" <strong>{flagged[0].upper()}{flagged[1:]}.</strong>" if flagged else ""
    law = "Linear elastic" if contact.bound == math.inf else "Elastic, perfectly plastic"
    return (
        f"<h2>Contact pressure at the {'worst impact' if run.impacts else 'largest force'}</h2>"
        f"<p>Wheel {peak.wheel + 1} at {peak.time:.4f} s, {peak.position:.3f} m: {contact.force / 1e3:.1f} kN, peak "
        f"pressure {contact.pressure.max() / 1e6:.0f} MPa, contact {x:.0f} mm long and {y:.1f} mm wide.{beyond}</p>"
        f"{plot}"
        f'<p class="quiet">{law}, solved for the recorded force with the treads in force.{rim}</p>'
    )


def known_frequencies(run: Survey, spectrum: Spectrum) -> list[tuple[float, str]]:
    """Frequencies, Hz, at which turns of the wheel and sleepers follow one another at the spectrum's speed."""
    lengths = (
        (2 * math.pi * run.rolling_radius, "turns of the wheel"),
        (run.info.sleeper_spacing, "sleepers"),
    )
    return [(spectrum.speed / length, name) for length, name in lengths if not math.isnan(length)]


def spectra(spectrum: Spectrum, plot: str) -> str:
    """Power spectral densities."""
    length = 2 * (len(spectrum.frequency) - 1)
    resolution = spectrum.frequency[1]
    how = f"mean of {spectrum.segments} segments" if spectrum.segments > 1 else "one segment"
    return (
        f"<h2>Spectra</h2><p>Power spectral density at {3.6 * spectrum.speed:.4g} km/h, up to half the sampling rate "
        f"of {2e-3 * spectrum.frequency[-1]:.4g} kHz.</p>{plot}"
        f'<p class="quiet">Welch’s method, {how} of {length} steps with a Hann window, {resolution:.3g} Hz apart.</p>'
    )


def what_ran(run: Survey) -> str:
    """What was in force by revision, scenario, versions."""
    info = run.info
    facts = {"bag": run.path.name, "scenario at the start": info.scenario_name, "digest": info.digest}
    if run.start_ns:
        start = datetime.fromtimestamp(run.start_ns / 1e9, tz=timezone.utc)
        facts["step 0"] = f"{start:%Y-%m-%d %H:%M:%S} UTC"
    facts["versions"] = ", ".join(f"{name} {number}" for name, number in info.versions.items()) or "unknown"
    lines = "".join(f"<tr><td>{name}</td><td class='quiet'>{escape(fact)}</td></tr>" for name, fact in facts.items())
    scenario = (
        f"<details><summary>Scenario</summary><pre>{escape(info.scenario)}</pre></details>" if info.scenario else ""
    )
    return f'<h2>What ran</h2>{_revisions(run)}<table class="facts"><tbody>{lines}</tbody></table>{scenario}'


def surfaces(run: Survey) -> str:
    """All irregularities in force, in one paragraph, or where to find them if they changed."""
    lists = [held.irregularities for held in run.in_force]
    if any(each != lists[0] for each in lists):
        what = "changed during the run: the revisions under “What ran” list them."
    else:
        what = f"throughout the run: {_listed(lists[0])}"
    return f'<p id="irregularities">Irregularities of treads and rails {what}</p>'


def _revisions(run: Survey) -> str:
    """Table of what was in force, revision by revision."""
    head = (
        "<th>revision</th><th class='wide'>step</th><th>from</th><th>speed driven</th><th class='wide'>set point</th>"
        "<th class='wide'>axle load</th>"
        "<th class='text'>irregularities of treads and rails</th>"
    )
    listed = run.in_force[:MOST_STATES]
    lines = "".join(
        f"<tr><td>{held.revision}</td><td class='wide'>{held.step}</td><td>{held.time:.4f} s</td>"
        f"<td>{between(held.speeds, 1 / 3.6, 'km/h') if held.speeds else 'none'}</td>"
        f"<td class='wide'>{_known(3.6 * held.set_point, 'km/h')}</td>"
        f"<td class='wide'>{_known(held.axle_load / 1e3, 'kN')}</td>"
        f"<td class='text'>{_irregularities(held, before)}</td></tr>"
        for before, held in zip([None, *listed], listed, strict=False)
    )
    more = (
        f"<p class='quiet'>The first {MOST_STATES} of {len(run.in_force)} revisions; info lists all.</p>"
        if len(run.in_force) > len(listed)
        else ""
    )
    table = f'<table id="revisions"><thead><tr>{head}</tr></thead><tbody>{lines}</tbody></table>'
    return f'<div class="list">{table}</div>{more}'


def _irregularities(held: InForce, before: InForce | None) -> str:
    same = before and before.irregularities and held.irregularities == before.irregularities
    return f"as in revision {before.revision}" if before and same else _listed(held.irregularities)


def _listed(irregularities: Iterable[Mapping[str, Any]] | None) -> str:
    if irregularities is None:
        return "unknown: the bag does not hold them"
    return "<br>".join(escape(description_of(item)) for item in irregularities) or "none"


def _known(value: float, unit: str) -> str:
    return "unknown" if math.isnan(value) else f"{value:.4g} {unit}"


def _around(time: float) -> tuple[float, float]:
    return time - VIEW[0], time + VIEW[1]


def _button(text: str, start: float, end: float) -> str:
    return f'<button type="button" data-from="{start:.9g}" data-to="{end:.9g}">{text}</button>'
