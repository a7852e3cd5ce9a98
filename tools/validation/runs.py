"""Passages: one run of a scenario over the paper's three bays, and the numbers that are kept of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.dynamics.interface import DynamicsModel
from wheelset_track_sim.dynamics.interface_kernels import advance, displacements
from wheelset_track_sim.errors import ContactError
from wheelset_track_sim.runtime.cache import digest
from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.models import Models, load_models
from wheelset_track_sim.simulation.simulator import CHANGEABLE, Simulator

from .store import recall

Real = NDArray[np.float64]
Alter = Callable[[Scenario, Models], Models]

BEFORE = AFTER = 0.9
"""m of track around the reference position: three sleeper bays (Section 5.4)."""
CREEP_STEPS = 30


@dataclass(frozen=True)
class Passage:
    """Forces in kN and maximum principal stresses in MPa of A1, B1, C1 over three bays around 1.8 m."""

    largest: list[float]
    smallest: list[float]
    loss: list[float]
    """Time without contact, ms."""
    jump: list[float]
    """Largest change of a force from one step to the next, kN."""
    stress: list[float]
    lowest: list[float]
    """Smallest stress, MPa."""
    x: list[float]
    """Position, m, from the reference position."""
    force: list[list[float]]
    """Force of each wheel at ``x``, kN."""
    creep: list[float]
    """Wheel 1 and rail together, 1e-10 m/N, after 1, 2, ... steps of a unit force that begins above a sleeper."""

    @property
    def rise(self) -> float:
        """Force of wheel 1 above the mean of both extremes, kN: the size of a ripple."""
        return (self.largest[0] - self.smallest[0]) / 2


def passage(
    name: str,
    changes: Sequence[str] = (),
    *,
    alter: Alter | None = None,
    key: Any = None,
    within: Callable[[], AbstractContextManager[Any]] = nullcontext,
    tables: bool = True,
) -> Passage | None:
    """Passage of a shipped scenario with ``key=value`` changes; None if it does not run to its end.

    ``alter`` changes the models before the run, ``within`` is entered around building and running; ``key`` names both
    for the store.
    """

    def compute() -> Any:
        scenario = load_scenario(name, changes)
        with within():
            models = shared_models(scenario, tables, None if within is nullcontext else key)
            if alter:
                models = alter(scenario, models)
            try:
                return _run(scenario, models)
            except ContactError:
                return None

    found = recall(
        "passage", [name, list(changes), key, tables], compute, alter, None if within is nullcontext else within
    )
    return None if found is None else Passage(**found)


_latest: dict[str, Models] = {}


def shared_models(scenario: Scenario, tables: bool | Literal["smooth"], key: Any) -> Models:
    """Models of a scenario; those of the call before if nothing but what may change during a run differs."""
    same = {name: value for name, value in scenario.to_mapping().items() if name not in CHANGEABLE}
    named = digest([same, tables, key])
    if named not in _latest:
        _latest.clear()
        _latest[named] = load_models(scenario, tables=tables)
    return _latest[named]


def must(found: Passage | None) -> Passage:
    """A passage that has to run to its end."""
    if found is None:
        raise RuntimeError("a passage that should run to its end does not")
    return found


def _run(scenario: Scenario, models: Models) -> dict[str, Any]:
    dx = scenario.step_length
    first = round((scenario.reference_position - BEFORE) / dx)
    last = round((scenario.reference_position + AFTER) / dx)
    block = Simulator(scenario, models=models).advance(last + 1)
    force = block.forces[first:] / 1e3
    stress = maximum_principal(block.stresses[first:]) / 1e6
    return {
        "largest": force.max(axis=0).tolist(),
        "smallest": force.min(axis=0).tolist(),
        "loss": ((force <= 0).sum(axis=0) * scenario.step_period * 1e3).tolist(),
        "jump": np.abs(np.diff(force, axis=0)).max(axis=0).tolist(),
        "stress": stress.max(axis=0).tolist(),
        "lowest": stress.min(axis=0).tolist(),
        "x": np.round(np.arange(len(force)) * dx - BEFORE, 6).tolist(),
        "force": np.round(force.T, 4).tolist(),
        "creep": creep(models.dynamics, dx, scenario.speed).tolist(),
    }


def creep(model: DynamicsModel, dx: float, speed: float, start: int = 0) -> Real:
    """Displacement (CREEP_STEPS,), 1e-10 m/N, of wheel 1 and rail by a unit force that begins at step ``start``."""
    dynamics, xi = model.start(0.0, start, dx, speed), np.empty((2, 2))
    unit, displaced = np.array([1.0, 0.0]), np.empty(CREEP_STEPS)
    for step in range(start, start + CREEP_STEPS):
        displacements(dynamics, step, xi)
        place = step % len(dynamics.rail_compliance)
        at_once = dynamics.wheel_compliance[0] + dynamics.rail_compliance[place]
        displaced[step - start] = xi[0, 0] + xi[1, 0] + at_once
        advance(dynamics, step, unit)
    return displaced * 1e10
