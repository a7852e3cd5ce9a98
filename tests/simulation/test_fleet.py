"""Wheelsets side by side: models in common, nothing that changes in common, the same bits as alone."""

import dataclasses
import gc
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from support.toy import toy_models
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation import fleet
from wheelset_track_sim.simulation.fleet import Fleet, ModelPool
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator

SCENARIOS = [
    load_scenario("damage_wheel_1"),
    load_scenario("undamaged", ["axle_load=250000.0"]),
    load_scenario("damage_wheel_2", ["speed=20.0"]),
    load_scenario("undamaged"),
]


def arrays(value, seen=None):
    """All arrays that an object holds, wherever they are in it."""
    seen = {} if seen is None else seen
    if id(value) in seen:
        return []
    seen[id(value)] = value
    if isinstance(value, np.ndarray):
        return [value]
    if isinstance(value, dict):
        inner = list(value.values())
    elif isinstance(value, (list, tuple)):
        inner = list(value)
    else:
        inner = [*vars(value).values()] if hasattr(value, "__dict__") and not isinstance(value, type) else []
    return [array for item in inner for array in arrays(item, seen)]


def joined(blocks):
    return [np.concatenate([getattr(block, name) for block in blocks]) for name in ("forces", "stresses")]


@pytest.mark.slow
def test_each_gives_the_same_bits_as_alone():
    with Fleet(SCENARIOS, threads=4) as together:
        assert len({id(simulator.models) for simulator in together.simulators}) == 1
        found = [[] for _ in SCENARIOS]
        for _ in range(4):
            for blocks, more in zip(found, together.advance(700), strict=True):
                blocks += more
    for scenario, blocks in zip(SCENARIOS, found, strict=True):
        alone = Simulator(scenario)
        forces, stresses = joined(blocks)
        expected = joined([alone.advance(1400), alone.advance(1400)])
        np.testing.assert_array_equal(forces, expected[0])
        np.testing.assert_array_equal(stresses, expected[1])
        assert len(np.unique(forces)) > 1000


@pytest.mark.parametrize("dynamics", ["causal", pytest.param("paper", marks=pytest.mark.slow)])
def test_a_neighbours_steps_touch_nothing_of_mine(dynamics, monkeypatch):
    monkeypatch.setattr("wheelset_track_sim.simulation.settling.SETTLING", 0.02)
    mine = load_scenario("undamaged", [f"dynamics={dynamics}", "speed=25"])  # of 4e-5 s a step: quick to transform
    # Without tables the active set is solved in every step, from its last solution.
    models = load_models(mine, tables=dynamics == "paper")
    simulator = Simulator(mine, models=models)
    neighbour = Simulator(dataclasses.replace(mine, axle_load=250e3), models=models)
    held = arrays(simulator)
    assert len(held) > 20
    before = [array.copy() for array in held]
    neighbour.advance(300)
    for array, kept in zip(held, before, strict=True):
        np.testing.assert_array_equal(array, kept)


def test_a_change_of_one_is_of_that_one():
    with Fleet(SCENARIOS[:2]) as together:
        first, second = together.simulators
        first.apply(dataclasses.replace(first.scenario, axle_load=180e3))
        blocks = together.advance(1000)
        assert [sum(map(len, part)) for part in blocks] == [1000, 1000]
        assert (first.in_force.axle_load, second.in_force.axle_load) == (180e3, 250e3)
        assert (first.revision, second.revision) == (1, 0)


@pytest.mark.slow
def test_models_are_built_once_for_all_and_freed_with_the_last(monkeypatch):
    built = []
    begun = threading.Barrier(4)

    def load(scenario, progress=None):
        built.append(scenario.name)
        return load_models(scenario, progress)

    monkeypatch.setattr(fleet, "load_models", load)
    pool = ModelPool()

    def take(scenario):
        begun.wait()
        return pool.models(scenario)

    with ThreadPoolExecutor(4) as threads:
        taken = list(threads.map(take, SCENARIOS))
    assert len(built) == 1
    assert all(models is taken[0] for models in taken)
    other = pool.models(load_scenario("undamaged", ["output.stress_nodes=[A1]"]))
    assert other is not taken[0]
    assert len(built) == 2
    taken.clear()
    gc.collect()
    pool.models(SCENARIOS[0])
    assert len(built) == 3


def test_who_fails_to_build_leaves_it_to_the_next(monkeypatch):
    attempts = []

    def load(scenario, progress=None):
        attempts.append(scenario)
        if len(attempts) == 1:
            raise KeyboardInterrupt
        return load_models(scenario, progress)

    monkeypatch.setattr(fleet, "load_models", load)
    pool = ModelPool()
    with pytest.raises(KeyboardInterrupt):
        pool.models(SCENARIOS[0])
    assert pool.models(SCENARIOS[0]).step_length == 1e-3


def test_a_wheelset_that_waits_for_the_models_of_another_says_so(monkeypatch):
    told, begun, built = [], threading.Event(), threading.Event()

    def slowly(scenario, progress):
        begun.set()
        assert built.wait(60.0)
        return toy_models()

    def progress(stage, fraction):
        told.append(stage)
        built.set()

    monkeypatch.setattr(fleet, "load_models", slowly)
    pool = ModelPool()
    with ThreadPoolExecutor(1) as other:
        first = other.submit(pool.models, SCENARIOS[0])
        assert begun.wait(60.0)
        assert pool.models(SCENARIOS[3], progress) is first.result()
    assert told == [fleet.WAITING]
