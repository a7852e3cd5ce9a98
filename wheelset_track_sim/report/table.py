"""Maxima and minima of a run as rows for people, and as a table for the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from rich.table import Table

from ..errors import printable
from ..samples.summary import Summary
from ..verdict.verdicts import worst
from .published import LoadCasePassage
from .survey import Survey

FEWEST_TURNS = 3
"""Turns from which on their scatter is shown."""


@dataclass(frozen=True)
class TableRow:
    """One figure in the unit that people use: of the whole run, of the passage that the paper prints, of the paper."""

    label: str
    unit: str
    run: float
    passage: float = math.nan
    """NaN if the run is none of the paper's load cases."""
    paper: float = math.nan
    """NaN where the paper prints none."""

    def cells(self) -> tuple[str, str, str, str]:
        """Run, passage, paper and the difference of these two as text; empty where there is nothing."""
        digits = 2 if self.unit in ("ms", "") else 1
        run, passage = (
            "" if math.isnan(value) else f"{value:.{digits}f} {self.unit}".rstrip()
            for value in (self.run, self.passage)
        )
        paper = "" if math.isnan(self.paper) else f"{self.paper:.3g} {self.unit}".rstrip()
        difference = f"{100 * (self.passage / self.paper - 1):+.1f} %" if self.paper > 0 else ""
        return run, passage, paper, difference


def rows(run: Survey) -> list[TableRow]:
    """Figures of a run, beside the paper's if there is something to compare."""
    load = run.wheel_load
    passage = _figures(run.passage.summary, load) if run.passage else {}
    printed = _figures(run.passage.case.printed, load) if run.passage else {}
    found = [
        TableRow(label, unit, value, passage.get((label, unit), math.nan), printed.get((label, unit), math.nan))
        for (label, unit), value in _figures(run.summary, load).items()
    ]
    if run.turns >= FEWEST_TURNS:
        names = [f"Contact force wheel {index}" for index in (1, 2)]
        names += [f"Max. principal stress {node}" for node in run.nodes]
        for number, (name, spread) in enumerate(zip(names, run.by_turn, strict=True)):
            size, unit = (1e3, "kN") if number < 2 else (1e6, "MPa")
            found.append(TableRow(f"{name}, median peak of {run.turns} turns", unit, spread.median / size))
            found.append(TableRow(f"{name}, smallest peak of a turn", unit, spread.low / size))
    amplitudes = zip(run.nodes, run.amplitudes, strict=True)
    return found + [
        TableRow(f"Bending amplitude {node}", "MPa", of / 1e6) for node, of in amplitudes if not math.isnan(of)
    ]


def _figures(summary: Summary, wheel_load: float) -> dict[tuple[str, str], float]:
    """Values of a summary by label and unit, in the order of the rows."""
    found: dict[tuple[str, str], float] = {}
    for index, load in enumerate(summary.wheels, start=1):
        found[f"Contact force wheel {index}, max", "kN"] = load.max_force / 1e3
        found[f"Contact force wheel {index}, min", "kN"] = load.min_force / 1e3
    if not math.isnan(wheel_load):
        for index, load in enumerate(summary.wheels, start=1):
            found[f"Dynamic factor wheel {index}", ""] = load.max_force / wheel_load
    for index, load in enumerate(summary.wheels, start=1):
        found[f"Time without contact wheel {index}", "ms"] = load.contact_loss * 1e3
    for node in summary.nodes:
        found[f"Max. principal stress {node.name}, max", "MPa"] = node.max_principal / 1e6
        found[f"Max. principal stress {node.name}, min", "MPa"] = node.min_principal / 1e6
    return found


def force_lines(run: Survey) -> dict[str, float]:
    """Forces that figures mark, N, by name: at rest, the threshold of impacts, limits of the verdict."""
    stated = run.limits.force if run.limits else ()
    lines = {"static": run.wheel_load, "impact": run.threshold}
    lines |= {f"{limit.level} {limit.above / 1e3:.4g} kN": limit.above for limit in stated}
    return {name: force for name, force in lines.items() if not math.isnan(force)}


def verdict_words(run: Survey) -> str:
    """The worst level of all verdicts with the name of the set; empty without limits."""
    if run.limits is None:
        return ""
    found = run.verdicts
    level = worst(found).word if found else "nothing to compare"
    return printable(f"{level}, by {run.limits.name}")


def title(run: Survey) -> str:
    """Bag, scenario at the start, and how often that was changed during the run."""
    changes = len(run.in_force) - 1
    changed = f", {changes} change{'s' if changes > 1 else ''} during the run" if changes > 0 else ""
    return printable(f"{run.path.absolute().name}: {run.info.scenario_name}{changed}")


def description(run: Survey) -> str:
    """Speeds driven, axle loads and length of a run in one line."""
    speed = between((speed for _, speed in run.speeds), 1 / 3.6, "km/h")
    load = f", axle load {between(run.axle_loads, 9810.0, 't')}" if run.axle_loads else ""
    dynamics = f", {run.scenario.dynamics} dynamics" if run.scenario else ""
    return f"{speed}{load}{dynamics}, {run.duration:.4g} s, {run.distance:.4g} m, {run.steps} steps"


def made_by(run: Survey) -> str:
    """Scenario, wheelset, track and the version that recorded them: the small print of every figure."""
    facts = [f"Scenario {run.info.scenario_name}"]
    facts += [f"{run.scenario.wheelset.name} on {run.scenario.track.name}"] if run.scenario else []
    version = run.info.versions.get("wheelset_track_sim", "of an unknown version")
    return printable(f"{', '.join(facts)}. Recorded by wheelset_track_sim {version}")


def between(values: Iterable[float], size: float, unit: str) -> str:
    """The range of values in SI in four digits of a ``unit`` of a ``size``, or the one value."""
    found = [value / size for value in values]
    low, high = min(found), max(found)
    one = math.isclose(low, high, rel_tol=1e-9)
    return f"{high:.4g} {unit}" if one else f"{low:.4g} to {high:.4g} {unit}"


def headings(run: Survey) -> tuple[str, ...]:
    """Headings of the columns that a table needs: those of ``TableRow.cells``, or only the first."""
    return ("whole run", "passage", "paper", "difference") if run.passage else ("whole run",)


def source(passage: LoadCasePassage) -> str:
    """Source of the paper's figures, and the part of the run that is compared with them."""
    return (
        f"Passage: {passage.start:.4g} to {passage.end:.4g} m, where angle 0 of the treads first meets the rail, "
        f"above a sleeper. Paper: {passage.case.source}."
    )


def summary_table(run: Survey) -> Table:
    """Table of a run for the terminal, with the paper's figures where the paper prints them."""
    table = Table(title=f"{title(run)}\n{description(run)}", title_justify="left", min_width=72)
    table.add_column("")
    for heading in headings(run):
        table.add_column(heading, justify="right")
    if run.passage:
        table.caption, table.caption_justify = source(run.passage), "left"
    unit = ""
    for row in rows(run):
        if unit and row.unit != unit:
            table.add_section()
        unit = row.unit
        table.add_row(row.label, *row.cells()[: len(headings(run))])
    if run.limits is not None:
        table.add_section()
        table.add_row("Verdict", verdict_words(run))
        lines = [printable(each.text) for each in run.verdicts]
        table.caption = "\n".join([*([str(table.caption)] if table.caption else []), *lines])
        table.caption_justify = "left"
    return table
