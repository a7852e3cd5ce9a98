"""Roughness on both treads and rails, every contact solved: ``python benchmarks/rough_wheels.py [SECONDS] [DECIBEL]``.

The whole coupled step at 100 km/h in memory, and single contacts at one force after the other.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import Any, NamedTuple

import numba
import numpy as np

from wheelset_track_sim.contact.law import build_contact_law
from wheelset_track_sim.contact.law_kernels import ContactLaw, solve_contact
from wheelset_track_sim.contact.solutions import approach_for_force
from wheelset_track_sim.irregularities import Roughness
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.changes import Condition, Revision
from wheelset_track_sim.simulation.coupled import Coupled
from wheelset_track_sim.simulation.models import Models, load_models

RAIL_STEPS = 6000
"""Length of the rails before they repeat: ten bays."""

LOADS = (50e3, 100e3, 200e3, 350e3)
"""N."""


class RoughRun(NamedTuple):
    """A wheelset at a step of its run over rough rails."""

    coupled: Coupled
    condition: Condition
    step_period: float

    def advance(self, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Contact forces (n, 2) N and stress components (n, S) Pa of the next ``steps`` steps."""
        preload = np.tile(self.condition.preload, (steps, 1))
        return self.coupled.run(self.condition, self.condition.scenario.speed, preload)


def rough_law(models: Models, level: float = 0.0) -> ContactLaw:
    """Contact law of two rough treads and rails, all different, each ``level`` dB above the limit of ISO 3095."""
    seeds = {"wheel_1": 1, "wheel_2": 2, "rail_1": 11, "rail_2": 12}
    rough = [Roughness(on, seed=seed, level=level) for on, seed in seeds.items()]
    dx, turn = models.step_length, models.steps_per_revolution
    return build_contact_law(rough, models.geometry, dx, turn, rail_steps=RAIL_STEPS)


def settled_run(level: float = 0.0, **changes: Any) -> RoughRun:
    """Rough wheels on rough rails, settled; ``changes`` to the scenario ``undamaged``."""
    scenario = replace(load_scenario("undamaged"), **changes)
    models = load_models(scenario)
    load, dx, speed = scenario.wheel_load, scenario.step_length, scenario.speed
    displaced = models.dynamics.preload(load, dx, speed)
    preload = displaced + approach_for_force(models.contact_law(()), 0, 0, 0, load)
    condition = Condition(Revision(0, 0), scenario, rough_law(models, level), preload)
    run = RoughRun(Coupled(models, load, 0, speed), condition, scenario.step_period)
    run.advance(round(0.5 / scenario.step_period))
    return run


@numba.njit(nogil=True, error_model="numpy")
def contacts(law: ContactLaw, approach: np.ndarray, forces: np.ndarray) -> None:
    """Forces (n,) N of wheel 1 at one step after the other."""
    none = np.empty((0, 0))
    for i in range(len(approach)):
        forces[i] = solve_contact(law, 0, i, i, approach[i], 0.0, law.in_contact[0], none)[0]


def time_of_contact(law: ContactLaw, load: float, steps: int = 300, rounds: int = 10) -> float:
    """Time of one solution around ``load`` N, s: the approach follows the roughness, as wheels nearly do."""
    approach = np.array([approach_for_force(law, 0, i, i, load) for i in range(0, steps, 10)])
    approach = np.interp(np.arange(steps), np.arange(0, steps, 10), approach)
    forces = np.empty(steps)
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        contacts(law, approach, forces)
        best = min(best, time.process_time() - start)
    assert np.isfinite(forces).all()
    return best / steps


def rough_wheels(seconds: float = 2.0, level: float = 0.0) -> dict[str, float]:
    """Real-time factor of the best part of a run, its forces, and the time of single contacts, us."""
    run = settled_run(level)
    steps = round(0.1 / run.step_period)
    found, best = [], np.inf
    for _ in range(max(1, round(seconds / 0.1))):
        start = time.process_time()
        forces, _ = run.advance(steps)
        best = min(best, time.process_time() - start)
        found.append(forces)
    all_forces = np.concatenate(found)
    single = {f"contact_{load / 1e3:.0f}_kN_us": 1e6 * time_of_contact(run.condition.law, load) for load in LOADS}
    return {
        "real_time_factor": steps * run.step_period / best,
        "least_kN": all_forces.min() / 1e3,
        "most_kN": all_forces.max() / 1e3,
        **single,
    }


if __name__ == "__main__":
    for name, value in rough_wheels(*map(float, sys.argv[1:])).items():
        print(f"{name}: {value:.3g}")
