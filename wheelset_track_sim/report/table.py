"""Maxima and minima of a run as rows for people, and as a table for the terminal."""

from __future__ import annotations

import math
from dataclasses import dataclass

from rich.table import Table

from ..errors import InputError
from ..recording import Recording
from ..scenario import Scenario, scenario_from
from ..yaml12 import parse
from .published import LoadCase, published_case


@dataclass(frozen=True)
class Row:
    """One figure of a run in the unit that people use, beside the paper's; NaN where the paper has none."""

    label: str
    unit: str
    value: float
    paper: float = math.nan

    @property
    def shown(self) -> str:
        """Value with unit."""
        return f"{self.value:.{2 if self.unit == 'ms' else 1}f} {self.unit}"

    @property
    def paper_shown(self) -> str:
        """The paper's value with unit, as printed there; empty if there is none."""
        return "" if math.isnan(self.paper) else f"{self.paper:g} {self.unit}"

    @property
    def difference(self) -> str:
        """Difference to the paper in percent; empty if there is nothing to compare."""
        return f"{100 * (self.value / self.paper - 1):+.1f} %" if self.paper > 0 else ""


def scenario_of(recording: Recording) -> Scenario | None:
    """Scenario of a run at its start; None if the bag has none that this version can read."""
    try:
        return scenario_from(parse(recording.info.scenario, "scenario of the bag"))
    except InputError:
        return None


def case_of(recording: Recording) -> LoadCase | None:
    """The paper's load case that a run is; None as soon as anything was changed on the way."""
    scenario = scenario_of(recording)
    changed = bool(recording.revision.any())
    return None if scenario is None or changed else published_case(scenario)


def rows(recording: Recording) -> list[Row]:
    """Figures of a whole run, beside the paper's if it is one of the load cases that the paper prints."""
    case, summary = case_of(recording), recording.summary
    high, low = (case.max_force, case.min_force) if case else ((math.nan, math.nan), (math.nan, math.nan))
    most, least = (case.max_principal, case.min_principal) if case else ({}, {})
    found = []
    for index, load in enumerate(summary.wheels):
        name = f"Contact force wheel {index + 1}"
        found += [
            Row(f"{name}, highest", "kN", load.max_force / 1e3, high[index] / 1e3),
            Row(f"{name}, lowest", "kN", load.min_force / 1e3, low[index] / 1e3),
        ]
    for index, load in enumerate(summary.wheels):
        found.append(Row(f"Time without contact wheel {index + 1}", "ms", load.contact_loss * 1e3))
    for node in summary.nodes:
        name = f"Maximum principal stress {node.name}"
        found += [
            Row(f"{name}, highest", "MPa", node.max_principal / 1e6, most.get(node.name, math.nan) / 1e6),
            Row(f"{name}, lowest", "MPa", node.min_principal / 1e6, least.get(node.name, math.nan) / 1e6),
        ]
    return found


def description(recording: Recording) -> str:
    """Speed, axle load and length of a run in one line."""
    slow, fast = 3.6 * recording.speed.min(), 3.6 * recording.speed.max()
    speed = f"{fast:.4g} km/h" if math.isclose(slow, fast, rel_tol=1e-9) else f"{slow:.4g} to {fast:.4g} km/h"
    scenario = scenario_of(recording)
    load = f", axle load {scenario.axle_load / 9.81e3:.4g} t, {scenario.dynamics} dynamics" if scenario else ""
    dx = float(recording.speed[0] * recording.step_period[0])
    return f"{speed}{load}, {recording.step_period.sum():.4g} s, {len(recording) * dx:.4g} m, {len(recording)} steps"


def summary_table(recording: Recording) -> Table:
    """Table of a run for the terminal; the paper's figures stand beside it where the paper prints them."""
    case = case_of(recording)
    table = Table(title=f"{recording.info.scenario_name}\n{description(recording)}", title_justify="left", min_width=72)
    table.add_column("")
    table.add_column("this run", justify="right")
    if case:
        table.add_column("paper", justify="right")
        table.add_column("difference", justify="right")
        table.caption = f"paper: {case.source}"
        table.caption_justify = "left"
    unit = ""
    for row in rows(recording):
        if unit and row.unit != unit:
            table.add_section()
        unit = row.unit
        table.add_row(row.label, row.shown, *((row.paper_shown, row.difference) if case else ()))
    return table
