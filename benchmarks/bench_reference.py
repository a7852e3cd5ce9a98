"""The same run by the plain reference and by the package's ``paper`` dynamics, 1 s of settling behind it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from benchmarks.conftest import Measure, group
from benchmarks.plain import Plain
from wheelset_track_sim.contact.solutions import approach_for_force, contact_filter, solver
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.coupled_kernels import run
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.settling import SETTLING

STEPS = 60
PLACES = {"smooth": 1000, "impact": 1770}
"""Steps from which ``STEPS`` are taken: on smooth treads, and from where the wheel begins to fall until it landed."""


class Settled(NamedTuple):
    """Arguments of the coupled step in ``paper`` dynamics, contacts solved in every step."""

    dynamics: Any
    law: Any
    preload: np.ndarray
    tread_origin: int
    first: int
    dt: float


@pytest.fixture(scope="module")
def settled() -> Callable[[str], Settled]:
    scenario = load_scenario("damage_wheel_1", ["dynamics=paper"])
    models = load_models(scenario, tables=False)
    damaged, smooth = (models.contact_law(defects) for defects in (scenario.irregularities, ()))
    load, dx, speed = scenario.wheel_load, scenario.step_length, scenario.speed
    first = -round(SETTLING / scenario.step_period)
    dynamics = models.dynamics.start(load, first, dx, speed)
    preload = models.dynamics.preload(load, dx, speed) + approach_for_force(smooth, 0, 0, 0, load)
    found = {}
    for name, place in PLACES.items():
        steps = place - first
        out = np.empty((steps, 2)), np.empty((steps, len(models.dynamics.stress_rows)))
        assert stepped(dynamics, smooth, np.tile(preload, (steps, 1)), models.tread_origin, first, *out) == steps
        here = dynamics._replace(past=dynamics.past.copy(), coming=dynamics.coming.copy(), done=dynamics.done.copy())
        found[name] = Settled(here, damaged, preload, models.tread_origin, place, scenario.step_period)
        first = place
    return found.__getitem__


def by_package(settled: Settled) -> tuple[np.ndarray, np.ndarray]:
    dynamics, law, preload, tread_origin, first, _ = settled
    dynamics = dynamics._replace(past=dynamics.past.copy(), coming=dynamics.coming.copy(), done=dynamics.done.copy())
    forces, stress = np.empty((STEPS, 2)), np.empty((STEPS, len(dynamics.stress)))
    assert stepped(dynamics, law, np.tile(preload, (STEPS, 1)), tread_origin, first, forces, stress) == STEPS
    return forces, stress


def stepped(dynamics: Any, law: Any, preload: Any, tread_origin: int, first: int, forces: Any, stress: Any) -> int:
    """Take coupled steps from ``first`` on; returns how many were solved."""
    rest = np.empty((len(forces), 0)), np.empty((len(forces), 2, 2)), np.zeros(3)
    origin, solving = tread_origin, (solver(law), contact_filter(law))
    return run(dynamics, law, *solving, preload, origin, first, forces, stress, *rest)


def by_plain(settled: Settled) -> tuple[np.ndarray, np.ndarray]:
    plain = Plain(*settled[:5])
    forces, stress = zip(*(plain.advance() for _ in range(STEPS)), strict=True)
    return np.array(forces), np.array(stress)


@group("reference")
@pytest.mark.parametrize("place", PLACES)
def test_plain(measure: Measure, settled: Callable[[str], Settled], place: str) -> None:
    start = settled(place)
    forces, stress = by_plain(start)
    expected, of_stress = by_package(start)
    assert np.abs(forces - expected).max() < 1e-3  # N of 98 kN
    assert np.abs(stress - of_stress).max() < 1.0  # Pa of 66 MPa
    assert (forces.min() == 0 < 150e3 < forces.max()) == (place == "impact")
    measure(lambda: by_plain(start), simulated=STEPS * start.dt, rounds=3)


@group("reference")
@pytest.mark.parametrize("place", PLACES)
def test_paper_dynamics(measure: Measure, settled: Callable[[str], Settled], place: str) -> None:
    start = settled(place)
    measure(lambda: by_package(start), simulated=STEPS * start.dt, rounds=10)
