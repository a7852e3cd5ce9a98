"""What a passage of a wayside detector costs, against the simulation of the track that counts for it."""

from __future__ import annotations

import time
from typing import Any

import pytest

from benchmarks.conftest import Measure, group
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.wayside.detector import load_detector
from wheelset_track_sim.wayside.history import first_that_counts, wayside_reading, window

POSITION = 12.0


def a_passage(name: str, rounds: int = 10) -> dict[str, Any]:
    """Processor time of a reading, the best of some, at a speed that has come before and at a new one."""
    scenario, detector = load_scenario("damage_wheel_1"), load_detector(name)
    track, dx = scenario.track, scenario.step_length
    begin, end = window(detector, track, POSITION, dx)
    run = Simulator(scenario)
    run.advance(first_that_counts(begin, track, dx))

    def timed(what: Any) -> tuple[float, Any]:
        start = time.process_time()
        found = what()
        return time.process_time() - start, found

    simulated, block = timed(lambda: run.advance(end + 1 - run.next_step))

    def read(speed: float) -> Any:
        return wayside_reading(detector, track, POSITION, block.forces, speed=speed, first_step=block.first_step)

    read(scenario.speed)  # for another speed, states of the track are there
    new, _ = timed(lambda: read(scenario.speed * 1.01))
    again = min(timed(lambda: read(scenario.speed * 1.01))[0] for _ in range(rounds))
    return {
        "detector": name,
        "channels": len(detector.channels),
        "passage_s": again,
        "new_speed_s": new,
        "to_simulation": again / simulated,
    }


@group("wayside")
@pytest.mark.parametrize("name", shipped.names("detectors"))
def test_wayside(record: Measure, name: str) -> None:
    record(lambda: a_passage(name))
