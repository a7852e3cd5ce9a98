"""Fatigue of the turning axle against the run that it is counted from, by turns: the ratio holds on any machine."""

from __future__ import annotations

import time

import pytest

from benchmarks.conftest import Measure, group
from wheelset_track_sim.cli.run import CHUNK
from wheelset_track_sim.fatigue.axle import AxleFatigue, TurningWheel
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.static_stress import static_stress
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

ROUNDS = 400
"""Chunks: as in the node, one of 50 ms at a time."""


@group("fatigue")
@pytest.mark.parametrize("case", ["damage_wheel_1", "flat_rounded", "undamaged"])
def test_three_nodes_at_36_angles(record: Measure, case: str) -> None:
    """Time to count over time to simulate, of the same chunks; and early against late, which must not grow."""
    simulator = Simulator(load_scenario(case))
    static = static_stress(simulator.scenario, simulator.models.reduced, ("A1", "B1", "C1"))
    fatigue = AxleFatigue(static, TurningWheel.of(simulator.scenario), load_curve("assumed_body"))
    simulator.settle()
    fatigue.push(simulator.advance(CHUNK))

    def measured() -> dict[str, float]:
        spent: list[tuple[float, float]] = []
        for _ in range(ROUNDS):
            start = time.process_time()
            block = simulator.advance(CHUNK)
            middle = time.process_time()
            fatigue.push(block)
            spent.append((middle - start, time.process_time() - middle))
        run, count = (sum(sorted(each)[: ROUNDS // 2]) for each in zip(*spent, strict=True))  # the quieter half
        halves = [
            sorted(each for _, each in part)[ROUNDS // 4] for part in (spent[: ROUNDS // 2], spent[ROUNDS // 2 :])
        ]
        period = simulator.step_period * CHUNK * (ROUNDS // 2)
        return {
            "to_run": count / run,
            "together": period / (run + count),
            "ns_a_step": 1e9 * count / (CHUNK * (ROUNDS // 2)),
            "growth": halves[1] / halves[0],
        }

    record(measured, case=case)
