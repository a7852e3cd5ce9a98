"""Where the time of a step goes: kernels alone, their arithmetic and traffic, and the most that the machine can do."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from benchmarks import profile_kernels
from benchmarks.conftest import Measure, group
from wheelset_track_sim.cli.run import CHUNK
from wheelset_track_sim.contact.solutions import approach_for_force
from wheelset_track_sim.runtime.one_core import one_core
from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.scenario import load_scenario, scenario_from
from wheelset_track_sim.simulation.coupled_kernels import run
from wheelset_track_sim.simulation.models import Models, load_models
from wheelset_track_sim.simulation.simulator import Simulator

NUMBER = 8
"""Bytes."""
STEPS = 2713
"""One turn: impact and smooth running in their proportion."""


class Run(NamedTuple):
    """One turn of damage_wheel_1, and what goes in and out of each kernel on the way."""

    models: Models
    law: Any
    preload: np.ndarray
    forces: np.ndarray  # (STEPS, 2)
    approach: np.ndarray  # (STEPS, 2) m, local
    stresses: np.ndarray  # (STEPS, nodes, 6)


@pytest.fixture(scope="module")
def turn() -> Run:
    scenario = load_scenario("damage_wheel_1")
    models = load_models(scenario)
    law = models.contact_law(scenario.irregularities)
    load, dx, speed = scenario.wheel_load, scenario.step_length, scenario.speed
    simulator = Simulator(scenario, models=models)
    parts = []
    while simulator.next_step < STEPS:
        parts.append(simulator.advance(STEPS - simulator.next_step))
    forces, stresses = (np.concatenate([getattr(part, name) for part in parts]) for name in ("forces", "stresses"))
    approach = np.array(
        [
            [approach_for_force(law, wheel, step - models.tread_origin, step, force[wheel]) for wheel in range(2)]
            for step, force in enumerate(forces)
        ]
    )
    preload = models.dynamics.preload(load, dx, speed) + approach_for_force(models.contact_law(()), 0, 0, 0, load)
    return Run(models, law, preload, forces, approach, stresses)


@pytest.fixture
def dynamics(turn: Run) -> Any:
    """At rest under the load, with a state of its own."""
    scenario = load_scenario("damage_wheel_1")
    return turn.models.dynamics.start(scenario.wheel_load, 0, scenario.step_length, scenario.speed)


class Work(NamedTuple):
    """Of one step: additions and multiplications, and bytes loaded and stored, by the cache that they come from."""

    flops: float
    near: float
    """From the first level: all but a few kilobytes of a step's coefficients and states are touched again at once."""
    far: float = 0.0
    """From the third level: what a place in the bay has of its own comes again only when the bay is over."""


def of_wheels(d: Any) -> Work:
    """Recursion and both displacements; rows of state (and back), factor, gains, outputs."""
    return Work(22 * d.wheel_modes, 14 * NUMBER * d.wheel_modes)


def of_track(d: Any) -> Work:
    """Recursion and displacement of both halves; input and output are those of the place."""
    modes = 2 * d.track_modes
    return Work(14 * modes, 6 * NUMBER * modes, 4 * NUMBER * modes)


def of_stress(d: Any) -> Work:
    """Sums of four components together; the state is loaded once for them."""
    groups = len(d.stress_output)
    return Work(16 * groups * d.stress_modes, 10 * NUMBER * groups * d.stress_modes)


def of_look_ups(law: Any) -> Work:
    """Bisection in one table for each wheel, then a straight piece."""
    halvings = float(np.log2(np.diff(law.first_point).mean()))
    return Work(2 * (2 * halvings + 8), 2 * 2 * NUMBER * halvings)


def of_principal(nodes: int) -> Work:
    """In the plane of symmetry: centre, radius, larger one; six components in, one number out."""
    return Work(nodes * 10, nodes * 7 * NUMBER)


def timed(measure: Measure, call: Callable[[], Any], work: Work | None = None, steps: int = STEPS) -> None:
    measure(call, rounds=60, steps=steps, **({} if work is None else work._asdict()))


@group("profile")
def test_wheelset(measure: Measure, turn: Run, dynamics: Any) -> None:
    alone = dynamics._replace(track_modes=0)
    timed(measure, lambda: profile_kernels.advance(alone, turn.forces), of_wheels(dynamics))


@group("profile")
def test_track(measure: Measure, turn: Run, dynamics: Any) -> None:
    alone = dynamics._replace(wheel_modes=0)
    timed(measure, lambda: profile_kernels.advance(alone, turn.forces), of_track(dynamics))


@group("profile")
def test_stress(measure: Measure, turn: Run, dynamics: Any) -> None:
    stress = np.empty((STEPS, len(dynamics.stress_direct)))
    call = lambda: profile_kernels.stresses(dynamics, turn.forces, stress)  # noqa: E731
    timed(measure, call, of_stress(dynamics))


@group("profile")
def test_look_ups(measure: Measure, turn: Run) -> None:
    found, first = np.empty((STEPS, 2)), -turn.models.tread_origin
    profile_kernels.look_ups(turn.law, first, turn.approach, found)
    assert np.abs(found - turn.forces).max() < 1e-3  # N
    timed(measure, lambda: profile_kernels.look_ups(turn.law, first, turn.approach, found), of_look_ups(turn.law))


@group("profile")
def test_coupled_step(measure: Measure, turn: Run, dynamics: Any) -> None:
    """All of the above in one loop."""
    forces, xi = np.empty((STEPS, 2)), np.empty((STEPS, 2, 2))
    stress = np.empty((STEPS, len(dynamics.stress_direct)))
    first = iter(range(0, 10**9, STEPS))

    preload = np.tile(turn.preload, (STEPS, 1))

    def call() -> None:
        solved = stepped(turn, dynamics, preload, next(first), forces, stress, np.empty((STEPS, 0)), xi)
        assert solved == STEPS

    timed(measure, call)


def stepped(turn: Run, dynamics: Any, preload: np.ndarray, first: int, *filled: np.ndarray) -> int:
    """Take one turn of coupled steps from the step ``first`` on, which fill arrays; returns how many were solved."""
    origin, untabled = turn.models.tread_origin, np.zeros(3)
    return run(dynamics, turn.law, None, None, preload, origin, first, *filled, untabled)


@group("profile")
def test_two_axle_boxes(record: Measure, turn: Run) -> None:
    """Share of the coupled step that acceleration at both boxes adds: turns with and without it by turns."""
    plain = load_scenario("damage_wheel_1").to_mapping()
    scenario = scenario_from({**plain, "sensors": [{"type": "axle_box_acceleration"}]})
    dynamics = load_models(scenario).dynamics.start(scenario.wheel_load, 0, scenario.step_length, scenario.speed)
    forces, xi = np.empty((STEPS, 2)), np.empty((STEPS, 2, 2))
    stress, signals = np.empty((STEPS, len(dynamics.stress_direct))), np.empty((STEPS, 2))
    preload, first = np.tile(turn.preload, (STEPS, 1)), iter(range(0, 10**9, STEPS))

    def spent(rows: int) -> float:
        start = time.process_time()
        assert stepped(turn, dynamics, preload, next(first), forces, stress, signals[:, :rows], xi) == STEPS
        return time.process_time() - start

    def share() -> dict[str, float]:
        without, both = np.array([(spent(0), spent(2)) for _ in range(400)]).min(axis=0)
        return {"share": float(both / without - 1.0), "ns_a_step": float(1e9 * (both - without) / STEPS)}

    record(share)


@group("profile")
def test_principal_stress(measure: Measure, turn: Run) -> None:
    stresses = np.ascontiguousarray(turn.stresses[:CHUNK].transpose(1, 2, 0)).transpose(2, 0, 1)
    timed(measure, lambda: maximum_principal(stresses), of_principal(stresses.shape[1]), CHUNK)


@group("profile")
def test_block(measure: Measure) -> None:
    """The coupled step, and handing over of blocks of 50 ms."""
    simulator = Simulator(load_scenario("damage_wheel_1"))
    timed(measure, lambda: [simulator.advance(CHUNK) for _ in range(2)], steps=2 * CHUNK)


@group("profile")
def test_block_and_summary(measure: Measure) -> None:
    """The same with maximum principal stresses and the summary of each block, as ``run`` does it."""
    simulator = Simulator(load_scenario("damage_wheel_1"))
    timed(measure, lambda: [summarise(simulator.advance(CHUNK)) for _ in range(2)], steps=2 * CHUNK)


@group("machine")
@pytest.mark.parametrize(("cache", "kilobytes"), [("L1", 16), ("L2", 512), ("L3", 6000), ("memory", 200_000)])
def test_loads(measure: Measure, cache: str, kilobytes: int) -> None:
    """Sum of an array that fits into a cache."""
    x = np.ones(kilobytes * 1000 // NUMBER)
    repeats = max(1, 1_000_000 // len(x))
    measure(lambda: profile_kernels.repeated_total(x, repeats), rounds=30, cache=cache, bytes=x.nbytes * repeats)


@group("machine")
def test_multiply_adds(measure: Measure) -> None:
    """Product of matrices: near the most additions and multiplications that one core does."""
    n = 600
    a, b, c = np.ones((n, n)), np.ones((n, n)), np.empty((n, n))
    with one_core():
        measure(lambda: np.matmul(a, b, out=c), rounds=30, flops=2 * n**3)
