"""Maxima and minima of a run as rows for people, and as a table for the terminal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from ..errors import InputError
from ..recording import Recording
from ..scenario import Scenario, scenario_from
from ..simulation.summary import Summary
from ..yaml12 import parse
from .published import LoadCase, published_case

BAYS = 3
"""Length of the passage; the damage meets the rail in its middle, as in the studies."""
ROUNDING = 1e-6
"""Far below a step and far above the rounding of a position, m."""


@dataclass(frozen=True)
class Row:
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
        digits = 2 if self.unit == "ms" else 1
        run, passage = (
            "" if math.isnan(value) else f"{value:.{digits}f} {self.unit}" for value in (self.run, self.passage)
        )
        paper = "" if math.isnan(self.paper) else f"{self.paper:g} {self.unit}"
        difference = f"{100 * (self.passage / self.paper - 1):+.1f} %" if self.paper > 0 else ""
        return run, passage, paper, difference


@dataclass(frozen=True)
class Comparison:
    """A load case that the paper prints, and the samples of a run that are this case."""

    case: LoadCase
    passage: slice
    start: float
    """Of the passage, m."""
    end: float
    """Of the passage, m."""


def scenario_of(recording: Recording) -> Scenario | None:
    """Scenario of a run at its start; None if the bag has none that this version can read."""
    try:
        return scenario_from(parse(recording.info.scenario, "scenario of the bag"))
    except InputError:
        return None


def comparison(recording: Recording) -> Comparison | None:
    """What of a run the paper prints; None if it is another case, or was changed on the way.

    The paper's damage meets the rail once, above a sleeper, and its maxima are those of three sleeper bays (Section
    5.4). In a longer run the damage comes back at other places of the bay; these passages are not the paper's case.
    """
    scenario, spacing = scenario_of(recording), recording.info.sleeper_spacing
    case = published_case(scenario) if scenario and not recording.revision.any() else None
    if scenario is None or case is None or math.isnan(spacing):
        return None
    first = scenario.reference_position - BAYS * spacing / 2
    last = first + BAYS * spacing
    if recording.position[0] > first + ROUNDING or recording.position[-1] < last - ROUNDING:
        return None
    start, stop = np.searchsorted(recording.position, [first - ROUNDING, last - ROUNDING])
    return Comparison(case, slice(int(start), int(stop)), first, last)


def rows(recording: Recording, compared: Comparison | None) -> list[Row]:
    """Figures of a run, beside the paper's if there is something to compare."""
    passage = _figures(recording.summary_of(compared.passage)) if compared else {}
    printed = _figures(compared.case.printed) if compared else {}
    return [
        Row(label, unit, value, passage.get((label, unit), math.nan), printed.get((label, unit), math.nan))
        for (label, unit), value in _figures(recording.summary).items()
    ]


def _figures(summary: Summary) -> dict[tuple[str, str], float]:
    """Values of a summary by label and unit, in the order of the rows."""
    found: dict[tuple[str, str], float] = {}
    for index, load in enumerate(summary.wheels, start=1):
        found[f"Contact force wheel {index}, max", "kN"] = load.max_force / 1e3
        found[f"Contact force wheel {index}, min", "kN"] = load.min_force / 1e3
    for index, load in enumerate(summary.wheels, start=1):
        found[f"Time without contact wheel {index}", "ms"] = load.contact_loss * 1e3
    for node in summary.nodes:
        found[f"Max. principal stress {node.name}, max", "MPa"] = node.max_principal / 1e6
        found[f"Max. principal stress {node.name}, min", "MPa"] = node.min_principal / 1e6
    return found


def description(recording: Recording) -> str:
    """Speed, axle load and length of a run in one line."""
    slow, fast = 3.6 * recording.speed.min(), 3.6 * recording.speed.max()
    speed = f"{fast:.4g} km/h" if math.isclose(slow, fast, rel_tol=1e-9) else f"{slow:.4g} to {fast:.4g} km/h"
    scenario = scenario_of(recording)
    load = f", axle load {scenario.axle_load / 9.81e3:.4g} t, {scenario.dynamics} dynamics" if scenario else ""
    dx = float(recording.speed[0] * recording.step_period[0])
    return f"{speed}{load}, {recording.step_period.sum():.4g} s, {len(recording) * dx:.4g} m, {len(recording)} steps"


def headings(compared: Comparison | None) -> tuple[str, ...]:
    """Headings of the columns that a table needs: those of ``Row.cells``, or only the first."""
    return ("whole run", "passage", "paper", "difference") if compared else ("whole run",)


def source(compared: Comparison) -> str:
    """What the figures of the paper are, and what of the run stands beside them."""
    return (
        f"Passage: {compared.start:.4g} to {compared.end:.4g} m, where angle 0 of the treads first meets the rail, "
        f"above a sleeper. Paper: {compared.case.source}."
    )


def summary_table(recording: Recording) -> Table:
    """Table of a run for the terminal; the paper's figures stand beside it where the paper prints them."""
    compared = comparison(recording)
    table = Table(title=f"{recording.info.scenario_name}\n{description(recording)}", title_justify="left", min_width=72)
    table.add_column("")
    for heading in headings(compared):
        table.add_column(heading, justify="right")
    if compared:
        table.caption, table.caption_justify = source(compared), "left"
    unit = ""
    for row in rows(recording, compared):
        if unit and row.unit != unit:
            table.add_section()
        unit = row.unit
        table.add_row(row.label, *row.cells()[: len(headings(compared))])
    return table
