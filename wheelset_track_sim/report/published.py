"""Figures of the paper for the load cases that it prints: facts to set beside a run, never inputs of one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..irregularities import Breakout
from ..scenario import Scenario

SPEED = 100 / 3.6
"""m/s, Section 5."""
AXLE_LOAD = 20_000 * 9.81
"""N, Section 5: 20 tonnes."""
SIZE_C = {"a": 0.030, "b": 0.024, "h": 0.002}
"""Size C of Table 2 with the depth of Section 5.1, m."""


@dataclass(frozen=True)
class LoadCase:
    """One line of Table 3, with what Section 5.1 adds to it. Forces in N, stresses in Pa."""

    source: str
    irregularities: tuple[Any, ...]
    max_force: tuple[float, float]
    """Wheel 1 and wheel 2."""
    max_principal: Mapping[str, float]
    """Maximum principal stress by node."""
    min_force: tuple[float, float] = (math.nan, math.nan)
    """NaN where the paper prints none."""
    min_principal: Mapping[str, float] = field(default_factory=dict)


CASES = (
    LoadCase(
        source="Table 3, no damage",
        irregularities=(),
        max_force=(131e3, 128e3),
        max_principal={"A1": 69.3e6, "B1": 66.6e6, "C1": 61.8e6},
    ),
    LoadCase(
        source="Table 3, damage on wheel 1; minima from Section 5.1",
        irregularities=(Breakout(on="wheel_1", **SIZE_C),),
        max_force=(358e3, 133e3),
        max_principal={"A1": 93.7e6, "B1": 85.4e6, "C1": 88.1e6},
        min_force=(0.0, math.nan),
        min_principal={"A1": 38.3e6},
    ),
)


def published_case(scenario: Scenario) -> LoadCase | None:
    """The paper's load case that a scenario is, by its content whatever its name; None if the paper prints none."""
    paper = (
        math.isclose(scenario.speed, SPEED, rel_tol=1e-6)
        and math.isclose(scenario.axle_load, AXLE_LOAD, rel_tol=1e-6)
        and (scenario.wheelset, scenario.track) == ("x40", "ballasted_60e1")
    )
    return next((case for case in CASES if paper and case.irregularities == scenario.irregularities), None)
