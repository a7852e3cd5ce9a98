"""Rough and out-of-round wheels against smooth ones, turn by turn in one run: the ratio holds on any machine."""

from __future__ import annotations

import time
from typing import Any

import pytest

from benchmarks.conftest import Measure, group
from wheelset_track_sim.cli.run import CHUNK
from wheelset_track_sim.samples.block import NO_CONTACTS
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

CASES = ("rough_wheel", "rail_roughness", "polygon", "measured_tread", "mixed", "long_wave", "four_rough_surfaces")
SURFACES = {"wheel_1": 1, "wheel_2": 2, "rail_1": 11, "rail_2": 12}
ROUGH = ", ".join(f"{{type: roughness, on: {on}, seed: {seed}}}" for on, seed in SURFACES.items())
FOUR_ROUGH = f"irregularities=[{ROUGH}]"
MEASURED = "{type: profile, on: wheel_1, file: synthetic_tread.csv, along: deg, height: mm, gaps: fill}"
TREAD = f"{MEASURED}, {{type: flat, on: wheel_2, length: 0.04}}"
HANGING = "track.line.supports=[{sleepers: 20-21, gap: 0.0005}]"
EVERYTHING = f"irregularities=[{ROUGH}, {TREAD}]"
SCENARIOS = {
    "four_rough_surfaces": ("undamaged", FOUR_ROUGH, "line_length=6.0"),
    "everything": ("scattered_support", HANGING, EVERYTHING, "line_length=6.0"),
}
"""Scenarios with settings, for cases that are not shipped."""
SUPPORTS = ("scattered_support", "hanging_sleeper", "everything")
"""Cases with supports that vary; their contacts, but for ``everything``, have tables."""


def simulator(case: str, *settings: str) -> Simulator:
    """Settled."""
    name, *changes = SCENARIOS.get(case, (case,))
    made = Simulator(load_scenario(name, [*changes, *settings]))
    made.settle()
    return made


def against_smooth(case: str, rounds: int = 30, steps: int = CHUNK) -> dict[str, Any]:
    """Real-time factors, best of ``rounds``, filtered and solved, as shares of the smooth case; and counts."""
    runs = {
        "smooth": simulator("undamaged"),
        "filtered": simulator(case),
        "solved": simulator(case, "contact.exact=true"),
    }
    best = dict.fromkeys(runs, float("inf"))
    counts = NO_CONTACTS
    for _ in range(rounds):
        for kind, run in runs.items():
            start = time.process_time()
            done = 0
            while done < steps:
                block = run.advance(steps - done)
                done += len(block)
                counts += block.contacts if kind == "filtered" else NO_CONTACTS
            best[kind] = min(best[kind], time.process_time() - start)
    period = runs["smooth"].step_period
    return {
        "real_time_factor": steps * period / best["filtered"],
        "to_smooth": best["smooth"] / best["filtered"],
        "solved_to_smooth": best["smooth"] / best["solved"],
        "share_filtered": counts.filtered_steps / max(counts.filtered_steps + counts.solved_steps, 1),
        "largest_estimate": counts.largest_estimate,
    }


@group("filter")
@pytest.mark.parametrize("case", CASES)
def test_filter(record: Measure, case: str) -> None:
    record(lambda: against_smooth(case), case=case)


@group("filter")
@pytest.mark.parametrize("case", SUPPORTS)
def test_supports(record: Measure, case: str) -> None:
    record(lambda: against_smooth(case, rounds=6), case=case)
