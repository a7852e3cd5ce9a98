"""Section 11: a bump on both rails by railFE, a public code, and by the causal dynamics."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from wheelset_track_sim.irregularities.surface import Patch, Surface
from wheelset_track_sim.runtime.arrays import Real
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

from .page import paragraphs, table
from .runs import shared_models
from .store import recall

HEIGHT, LENGTH = 0.3e-3, 0.3
"""m."""
POSITION, END = 6.0, 9.0
"""Of the middle of the bump, above a sleeper, and of the run, m."""
OTHER = (22.1, -20.6)
"""Largest and smallest force of railFE over the static one, kN: rigid half sleepers, a wheel of 971.5 kg, and a linear
contact of 1.26 GN/m, on the printed track at 100 km/h."""
CORRELATION = 0.993
"""Of both histories over the bump, as found when railFE was run."""


@dataclass(frozen=True)
class Bump:
    """A wave of one cosine on a rail."""

    on: str

    @property
    def end(self) -> float:
        """Position where it ends, m."""
        return POSITION + LENGTH / 2

    def height(self, s: Real) -> Real:
        """Height, m, at ``s`` from the middle, m."""
        return HEIGHT * (0.5 + 0.5 * np.cos(2 * np.pi * np.clip(s / LENGTH, -0.5, 0.5)))

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface``, the same at all lateral positions."""
        yield surface.around(surface.at(POSITION), LENGTH / 2, self.height)


def _extremes() -> list[float]:
    scenario = load_scenario("undamaged")
    models, bumps = shared_models(scenario, "smooth", None), tuple(Bump(rail) for rail in ("rail_1", "rail_2"))
    changed: Any = {"irregularities": bumps}
    run = Simulator(dataclasses.replace(scenario, **changed), models=models)
    force = run.advance(round(END / scenario.step_length)).forces[:, 0] - scenario.wheel_load
    return [force.max() / 1e3, force.min() / 1e3]


def ours() -> list[float]:
    """Largest and smallest force over the static one, kN."""
    found: list[float] = recall("bump", [HEIGHT, LENGTH], _extremes)
    return found


def section() -> str:
    """Text of the section."""
    return paragraphs(
        "## 11. A bump, by another code",
        f"A cosine bump of {1e3 * HEIGHT:g} mm over {1e3 * LENGTH:g} mm on both rails above a sleeper, at 100 km/h. "
        "railFE is a public finite-element code of one rail, with rigid half sleepers, a wheel of 971.5 kg and a "
        "linear contact of 1.26 GN/m. It was run with the printed track, and its numbers are typed here. Force of "
        "wheel 1 over the static one:",
        table(
            ("", "largest, kN", "smallest, kN"),
            [["railFE", *OTHER], ["causal", *ours()]],
        ),
        f"The two histories have a correlation of {CORRELATION:g}.",
    )
