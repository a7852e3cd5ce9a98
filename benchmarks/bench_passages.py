"""Distinct defects a second: one passage each of a defect that has never been seen, and the same with force tables."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.conftest import Measure, group
from wheelset_track_sim.irregularities import Breakout, Flat, Irregularity
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.passages import Passages
from wheelset_track_sim.simulation.simulator import Simulator


def defects(seed: int) -> Iterator[Irregularity]:
    """Breakouts, fresh flats and rounded flats in turn, of random sizes, up to a bay behind a sleeper."""
    draw = np.random.default_rng(seed).uniform
    while True:
        angle = draw(0.0, 0.6) / 0.4318
        yield Breakout("wheel_1", a=draw(0.01, 0.04), b=draw(0.01, 0.03), h=draw(2e-4, 2e-3), angle=angle)
        yield Flat("wheel_1", length=draw(0.02, 0.06), angle=angle)
        yield Flat("wheel_1", length=(length := draw(0.02, 0.06)), worn_length=draw(1.2, 2.0) * length, angle=angle)


def a_second(count: int = 60, tabled: int = 6) -> dict[str, Any]:
    """Defects a second, mean over ``count``, and over ``tabled`` by simulations of their own with force tables."""
    scenario = load_scenario("undamaged", ["settle_on=smooth"])
    passages, own = Passages(scenario, after=1.5), load_models(scenario)

    def alone(defect: Irregularity) -> None:
        run = Simulator(dataclasses.replace(scenario, irregularities=(defect,)), models=own)
        run.advance(passages.first_step + passages.steps)

    found = {}
    for name, passage, number in (("passages", lambda each: passages.run([each]), count), ("tabled", alone, tabled)):
        drawn = defects(1)
        for _ in range(3):
            passage(next(drawn))
        start = time.process_time()
        for _ in range(number):
            passage(next(drawn))
        found[name] = number / (time.process_time() - start)
    return {"in_a_second": found["passages"], "in_a_second_with_tables": found["tabled"], "count": count}


@group("passages")
def test_distinct_defects(record: Measure) -> None:
    record(a_second)
