"""What all shortcuts of the stepping loop together change, against ``unreduced``: below 0.1 % of the static load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from support.unreduced import Unreduced
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import WHEELS, Scenario, load_scenario
from wheelset_track_sim.simulation.models import Models, load_models
from wheelset_track_sim.simulation.settling import SETTLING
from wheelset_track_sim.simulation.simulator import Simulator

BOUND = 1e-3
"""Of the static load, and of the largest static component of a node's stress."""

CASES = ("undamaged", "damage_wheel_1", "damage_wheel_2", "damage_both")
SEEDS = (1, 2, 3, 4)

Record = Callable[[str, object], None]


@pytest.fixture(scope="module")
def models() -> Models:
    return load_models(load_scenario("undamaged"))


@pytest.fixture(scope="module")
def settled(models: Models) -> Callable[[float], Unreduced]:
    """A wheelset that has run on smooth treads for as long as the simulator's, by speed.

    The force of smooth treads is taken from their table, to 1e-6 what the solver finds: it only leads to the start.
    """

    @lru_cache(maxsize=1)
    def at(speed: float) -> Unreduced:
        scenario = load_scenario("undamaged", [f"speed={speed!r}"])
        steps = round(SETTLING / scenario.step_period)
        run = Unreduced(scenario, models, -steps)
        run.run(models.contact_law(()), steps)
        return run

    return at


def check(scenario: Scenario, models: Models, settled: Callable[[float], Unreduced], record: Record) -> None:
    simulator = Simulator(scenario, models=models)
    block = simulator.advance(simulator.steps_per_revolution)
    reference = settled(scenario.speed).copy()
    forces, stresses = reference.run(reference.solver(scenario), len(block))
    static = np.abs(reference.wheelset.static_stress().sum(axis=-1)).max(axis=-1) * scenario.wheel_load

    of_force = np.abs(block.forces - forces).max() / scenario.wheel_load
    of_stress = (np.abs(block.stresses - stresses).max(axis=(0, 2)) / static).max()
    record("force_error", float(of_force))  # workers hand over plain numbers only
    record("stress_error", float(of_stress))
    extremes = f"peak {forces.max() / 1e3:.1f} kN, least {forces.min() / 1e3:.1f} kN"
    print(f"{scenario.name}: force {1e6 * of_force:.0f}, stress {1e6 * of_stress:.0f} millionths ({extremes})")
    assert of_force < BOUND
    assert of_stress < BOUND


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_load_cases(name: str, models: Models, settled: Callable, record_property: Record) -> None:
    check(load_scenario(name), models, settled, record_property)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_defect(seed: int, models: Models, settled: Callable, record_property: Record) -> None:
    """Of any size, off the middle of the tread, meeting the rail anywhere in a bay."""
    draw = np.random.default_rng(seed).uniform
    defect = Breakout(
        on=WHEELS[seed % 2],
        a=draw(0.005, 0.06),
        b=draw(0.005, 0.03),
        h=draw(1e-4, 2.5e-3),
        angle=draw(-1.5, 1.5),
        y=draw(-0.01, 0.01),
    )
    scenario = replace(load_scenario("undamaged"), name=f"random {seed}", irregularities=(defect,), settle_on="smooth")
    check(scenario, models, settled, record_property)


@pytest.mark.slow
@pytest.mark.parametrize("kmh", [40, 220])
def test_other_speeds(kmh: int, models: Models, settled: Callable, record_property: Record) -> None:
    check(load_scenario("damage_wheel_1", [f"speed={kmh / 3.6!r}"]), models, settled, record_property)
