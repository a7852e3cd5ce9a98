"""Tracks whose supports vary: the step of the bays against that of the modes of equal ones, turn by turn in one run."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from benchmarks import profile_kernels
from benchmarks.conftest import Measure, group
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models

CASES = {
    "scattered supports": ("scattered_support",),
    "three sleepers hang": ("scattered_support", "track.line.supports=[{sleepers: 20-22, gap: 0.001}]"),
    "all sleepers hang": ("scattered_support", 'track.line.supports=[{sleepers: "0-79", gap: 0.0}]'),
    "slab": ("slab_track", "track={base: slab_60e1, line: {scatter: {pad_stiffness: 0.2}}}"),
}
STEPS = 1200


def step_of(case: str, rounds: int = 60) -> dict[str, Any]:
    """Time of a step of wheelset and bays, ns, and of wheelset and modes."""
    forces, running = np.full((STEPS, 2), 98.1e3), []
    for name, *settings in (CASES[case], ("undamaged",)):
        scenario = load_scenario(name, settings)
        dynamics = load_models(scenario).dynamics
        running.append(dynamics.start(scenario.wheel_load, 0, scenario.step_length, scenario.speed))
    best = [np.inf, np.inf]
    for _ in range(rounds):
        for each, dynamics in enumerate(running):
            begun = time.process_time()
            profile_kernels.advance(dynamics, forces)
            best[each] = min(best[each], time.process_time() - begun)
    line, modes = (1e9 * each / STEPS for each in best)
    return {"line_ns": line, "modes_ns": modes, "ratio": line / modes}


@group("lines")
@pytest.mark.parametrize("case", CASES)
def test_line_step(record: Measure, case: str) -> None:
    record(lambda: step_of(case), case=case)
