"""How cost grows: with simulated time, length of the ring, states of the track, modes of the wheelset and defects."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.conftest import Measure, group
from wheelset_track_sim.cli.run import CHUNK
from wheelset_track_sim.dynamics.causal import causal_model
from wheelset_track_sim.dynamics.running_wheelset import truncated
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.models import Models, load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.balance import ORDER, MovingTrack, balanced
from wheelset_track_sim.track.ring import track_ring
from wheelset_track_sim.wheelset.reduction import reduced_wheelset

BLOCKS = 10


def advancing(
    measure: Measure, scenario: Scenario, models: Models | None = None, blocks: int = BLOCKS, **facts
) -> None:
    simulator = Simulator(scenario, models=models)
    simulated = blocks * CHUNK * simulator.step_period
    measure(lambda: [simulator.advance(CHUNK) for _ in range(blocks)], simulated=simulated, rounds=15, **facts)


@group("scaling: simulated time")
@pytest.mark.parametrize("seconds", [0, 30, 300])
def test_after(measure: Measure, seconds: float) -> None:
    """The same half second, so much later in the run."""
    simulator = Simulator(load_scenario("damage_wheel_1"))
    while simulator.time < seconds:
        simulator.advance(CHUNK)
    simulated = BLOCKS * CHUNK * simulator.step_period
    run = lambda: [simulator.advance(CHUNK) for _ in range(BLOCKS)]  # noqa: E731
    measure(run, simulated=simulated, rounds=15, seconds=seconds)


def with_track(models: Models, bays: int, order: int) -> Models:
    ring = track_ring(models.track, models.step_length, bays=bays)
    halves = (balanced(half, order) for half in (ring.symmetric, ring.antisymmetric))
    return replace(models, dynamics=replace(models.dynamics, track=MovingTrack(*halves)))


@group("scaling: bays of the ring")
@pytest.mark.parametrize("bays", [40, 80, 140])
def test_bays(measure: Measure, bays: int) -> None:
    scenario = load_scenario("damage_wheel_1")
    models = load_models(scenario)
    ring = track_ring(models.track, models.step_length, bays=bays)
    modes = sum(len(half.poles) for half in (ring.symmetric, ring.antisymmetric))
    start = time.process_time()
    running = with_track(models, bays, ORDER)
    advancing(measure, scenario, running, bays=bays, ring_modes=modes, reduction_s=time.process_time() - start)


@group("scaling: states of the track")
@pytest.mark.parametrize("order", [50, 100, 200, 400])
def test_states(measure: Measure, order: int) -> None:
    scenario = load_scenario("damage_wheel_1")
    advancing(measure, scenario, with_track(load_models(scenario), 80, order), order=order)


@group("scaling: modes of the wheelset")
@pytest.mark.parametrize("hz", [1500, 3000, 6000])
def test_modes(measure: Measure, hz: float) -> None:
    scenario = load_scenario("damage_wheel_1")
    models = load_models(scenario)
    kept = truncated(reduced_wheelset(models.wheelset), hz)
    nodes, track = scenario.output.stress_nodes, models.dynamics.track
    models = replace(models, dynamics=causal_model(kept, track, nodes, scenario.at_lag_zero))
    advancing(measure, scenario, models, modes=len(kept.poles))


@group("scaling: defects")
@pytest.mark.parametrize(("count", "y"), [(0, 0.0), (1, 0.0), (4, 0.0), (16, 0.0), (1, 0.005)])
def test_defects(measure: Measure, count: int, y: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Defects of random size around wheel 1, beside the middle at ``y``; their tables are built anew."""
    draw = np.random.default_rng(count).uniform
    defects = tuple(
        Breakout("wheel_1", draw(0.01, 0.03), draw(0.01, 0.024), draw(3e-4, 2e-3), 2 * np.pi * i / max(count, 1), y)
        for i in range(count)
    )
    scenario = replace(load_scenario("undamaged"), name=f"{count} defects", irregularities=defects)
    models = load_models(scenario)
    monkeypatch.setenv("WHEELSET_TRACK_SIM_CACHE", str(tmp_path))
    models.contact_law((Breakout("wheel_1", 0.01, 0.01, 1e-3),))  # kernels load with the first tables
    start = time.process_time()
    law = models.contact_law(defects)
    built = time.process_time() - start
    tables, megabytes = len(law.first_point) - 1, law.points.nbytes / 1e6
    advancing(
        measure, scenario, models, defects=count, y_mm=1e3 * y, tables=tables, tables_mb=megabytes, tables_s=built
    )
