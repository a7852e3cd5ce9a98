import copy
import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import ContactError, DivergenceError, WheelsetTrackError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.coupled import require_finite
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator


def test_finite_samples_pass() -> None:
    require_finite(0, forces=np.full((3, 2), 1e5), stress=np.zeros((3, 0)))
    require_finite(0, huge=np.array([[1e308], [1e308], [-1e308]]))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_step_that_is_not_finite_is_named_with_its_values(value: float) -> None:
    forces, stress = np.full((5, 2), 98e3), np.ones((5, 3, 6))
    stress[3:, 1, 4] = value
    forces[4] = np.nan
    with pytest.raises(DivergenceError, match=rf"^step 10003 is not finite \(forces \[98000\. 98000\.\], .*{value}"):
        require_finite(10_000, forces=forces, stress=stress)


@pytest.mark.parametrize("of", ["wheels", "track"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_not_finite_ends_in_an_error_with_its_step(of: str, value: float) -> None:
    simulator = Simulator(load_scenario("undamaged"))
    simulator.advance(100)
    getattr(simulator._coupled._dynamics, of)[..., 0] = value
    with pytest.raises((ContactError, DivergenceError), match=r"step 10[01]\b"):
        _advance_to(simulator, 200)
    with pytest.raises((ContactError, DivergenceError)):  # and it stays one
        simulator.advance(1)


def test_stress_that_is_not_finite_ends_in_an_error() -> None:
    scenario = load_scenario("undamaged")
    models = load_models(scenario)
    feedthrough = models.dynamics.stress_feedthrough.copy()  # type: ignore[attr-defined]
    feedthrough[2] = np.nan
    dynamics = dataclasses.replace(models.dynamics, stress_feedthrough=feedthrough)  # type: ignore[type-var]
    with pytest.raises(WheelsetTrackError, match="is not finite"):
        Simulator(scenario, models=dataclasses.replace(models, dynamics=dynamics)).advance(1)


def test_a_run_that_does_not_settle_does_not_begin() -> None:
    scenario = load_scenario("undamaged")
    models = load_models(scenario)
    wheelset = copy.copy(models.dynamics.wheelset)  # type: ignore[attr-defined]
    object.__setattr__(wheelset, "poles", wheelset.poles + 300.0)  # whose motion grows
    dynamics = dataclasses.replace(models.dynamics, wheelset=wheelset)  # type: ignore[type-var]
    simulator = Simulator(scenario, models=dataclasses.replace(models, dynamics=dynamics))
    with pytest.raises(ContactError, match=r"contact problem of step -2\d{4} has no solution"):
        simulator.settle()


def _advance_to(simulator: Simulator, step: int) -> None:
    """Samples before a step that is not finite are handed over first."""
    while simulator.next_step < step:
        block = simulator.advance(50)
        assert np.isfinite(block.forces).all()
        assert np.isfinite(block.stresses).all()
