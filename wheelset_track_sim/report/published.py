"""Figures of the paper for the load cases that it prints: facts to set beside a run, never inputs of one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

from ..irregularities import Breakout
from ..samples.summary import NodeStress, Summary, WheelLoad
from ..scenario import Scenario
from ..track.track import load_track
from ..wheelset.kinds import load_wheelset
from .samples import SampleSeries

SPEED = 100 / 3.6
"""m/s, Section 5."""
AXLE_LOAD = 20_000 * 9.81
"""N, Section 5: 20 tonnes."""
SIZE_C = {"a": 0.030, "b": 0.024, "h": 0.002}
"""Size C of Table 2 with the depth of Section 5.1, m."""
BAYS = 3
"""Length of the passage that the paper prints; the damage meets the rail in its middle, as in the studies."""


@dataclass(frozen=True)
class LoadCase:
    """One line of Table 3, with what Section 5.1 adds to it."""

    source: str
    irregularities: tuple[Any, ...]
    printed: Summary
    """The paper's figures in N and Pa; NaN where it prints none."""


@dataclass(frozen=True, eq=False)
class LoadCasePassage:
    """The part of a run that is a load case of the paper."""

    case: LoadCase
    start: float
    """m"""
    end: float
    """m"""
    summary: Summary
    samples: SampleSeries


def _printed(wheels: Iterable[tuple[float, float]], nodes: Mapping[str, tuple[float, float]]) -> Summary:
    """Summary from (largest, smallest) force of each wheel in kN and (largest, smallest) stress of each node in MPa."""
    wheel_1, wheel_2 = (WheelLoad(1e3 * high, 1e3 * low, nan, nan, nan) for high, low in wheels)
    stresses = tuple(NodeStress(name, 1e6 * high, 1e6 * low, nan, nan) for name, (high, low) in nodes.items())
    return Summary(0, (wheel_1, wheel_2), stresses)


CASES = (
    LoadCase(
        source="Table 3, no damage",
        irregularities=(),
        printed=_printed([(131, nan), (128, nan)], {"A1": (69.3, nan), "B1": (66.6, nan), "C1": (61.8, nan)}),
    ),
    LoadCase(
        source="Table 3, damage on wheel 1; minima from Section 5.1",
        irregularities=(Breakout(on="wheel_1", **SIZE_C),),
        printed=_printed([(358, 0), (133, nan)], {"A1": (93.7, 38.3), "B1": (85.4, nan), "C1": (88.1, nan)}),
    ),
)


def published_case(scenario: Scenario) -> LoadCase | None:
    """The paper's load case that a scenario is, by its content whatever its name; None if the paper prints none."""
    paper = (
        math.isclose(scenario.speed, SPEED, rel_tol=1e-6)
        and math.isclose(scenario.axle_load, AXLE_LOAD, rel_tol=1e-6)
        and not (scenario.speed_plan or scenario.events)
        and scenario.loads.none
        and (scenario.wheelset, scenario.track) == (load_wheelset("x40"), load_track("ballasted_60e1"))
    )
    return next((case for case in CASES if paper and case.irregularities == scenario.irregularities), None)


def published_passage(scenario: Scenario | None, spacing: float) -> tuple[LoadCase, float, float] | None:
    """What of a run the paper prints, from and to a position, m; None if it is another case.

    The paper's damage meets the rail once, above a sleeper, and its maxima are those of three sleeper bays (Section
    5.4). In a longer run the damage comes back at other places of the bay; these passages are not the paper's case.
    """
    case = published_case(scenario) if scenario else None
    if scenario is None or case is None or math.isnan(spacing):
        return None
    first = scenario.reference_position - BAYS * spacing / 2
    return case, first, first + BAYS * spacing
