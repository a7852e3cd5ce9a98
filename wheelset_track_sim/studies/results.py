"""What came out of a study, beside what the paper prints."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ..report.published import published_case
from ..scenario import Scenario
from ..verdict.limit_set import Level, LimitSet, load_limits
from ..verdict.verdicts import verdicts, worst
from .axes import Axis, Point
from .evaluate import Result
from .outputs import FORCES, LARGEST, SMALLEST, STARRED, value_of
from .study import Study, StudyRun

SLEEPER_SPACING = 0.6
"""m, Section 4."""
PAPER_BAND = 2500.0
"""Hz, Section 5.1."""


@dataclass(frozen=True)
class Results:
    """A study with its runs; ``found`` and ``failures`` go by the index of the run."""

    name: str
    study: Study
    runs: tuple[StudyRun, ...]
    found: Mapping[int, Result]
    failures: Mapping[int, str]

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """What is varied."""
        return self.study.axes

    def axis(self, name: str) -> Axis:
        """Axis of a name."""
        return next(axis for axis in self.axes if axis.name == name)

    def point(self, index: int, name: str) -> Point:
        """Place of a run on the axis of a name."""
        return next(point for axis, point in zip(self.axes, self.runs[index].points, strict=True) if axis.name == name)

    @cached_property
    def dynamics(self) -> str:
        """Dynamics of the runs, as a sentence's subject: ``causal dynamics``."""
        return " and ".join(sorted({run.scenario.dynamics for run in self.runs})) + " dynamics"

    @property
    def made_by(self) -> str:
        """What made the results, and over which stretch of track: the small print of every figure."""
        window = self.study.window
        scenarios = [run.scenario for run in self.runs]
        said = (
            {f"Scenario {each.name}" for each in scenarios},
            {f"{each.wheelset.name} on {each.track.name}" for each in scenarios},
            {self.dynamics},
            {f"axle load {each.axle_load / 9810:.4g} t" for each in scenarios},
            {f"{3.6 * each.speed:.4g} km/h" for each in scenarios},
        )
        facts = ", ".join(fact for same in said if len(same) == 1 for fact in same)
        if self.study.places > 1:
            facts += f"; {self.study.places} places of the bay: medians, and bands from smallest to largest"
        facts += f"; {window.before:g} m before to {window.after:g} m after angle 0 of the treads"
        return ". ".join(filter(None, (facts, self.note)))

    @property
    def note(self) -> str:
        """Material constants on which starred outputs depend, with their source; empty if there are none."""
        curve = self.study.sn_curve
        return f"* by the {curve.note}" if curve and any(STARRED in name for name in self.study.outputs) else ""

    def value(self, index: int, output: str) -> float:
        """Output of a run, SI; NaN if the run failed."""
        found = self.found.get(index)
        return found.values[output] if found else math.nan

    @cached_property
    def limits(self) -> LimitSet | None:
        """What the runs are compared with; None if no largest force is kept, or there are no limits."""
        return load_limits(self.study.limits) if set(FORCES) & {*self.study.outputs} else None

    def verdict(self, index: int) -> Level:
        """Worst level of the forces, over all places, and of the damage; raises KeyError if the run failed."""
        assert self.limits is not None
        kept = self.found[index].values
        forces = [kept.get(name + LARGEST, kept.get(name, math.nan)) for name in FORCES]
        return worst(verdicts(self.limits, forces, self.runs[index].scenario.irregularities))

    def ends(self, index: int, output: str) -> tuple[float, float]:
        """Smallest and largest over the places of the bay, SI; NaN if the run failed, or has one place."""
        values = self.found[index].values if index in self.found else {}
        return values.get(output + SMALLEST, math.nan), values.get(output + LARGEST, math.nan)

    def published(self, index: int, output: str) -> float:
        """What the paper prints for the case of a run, SI; NaN where it prints nothing."""
        return published(self.runs[index].scenario, output)


def published(scenario: Scenario, output: str) -> float:
    """What the paper prints for a scenario, SI; NaN where it prints nothing.

    A defect without depth is no damage, and the band limit of the paper is part of its case if there is one.
    """
    bays = scenario.reference_position / SLEEPER_SPACING
    if scenario.max_frequency not in (None, PAPER_BAND) or not math.isclose(bays, round(bays), abs_tol=1e-6):
        return math.nan
    damage = tuple(defect for defect in scenario.irregularities if getattr(defect, "h", 1.0) != 0.0)
    case = published_case(dataclasses.replace(scenario, irregularities=damage))
    return value_of(case.printed, output) if case else math.nan
