"""The streaming dynamics against the paper's Green's functions: one coupled step, two independent paths to it."""

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.dynamics.paper import PaperModel
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator

STATIC = 98.1e3
COARSE = "step_length=0.002"


def one_turn(name: str, *changes: str) -> SampleBlock:
    simulator = Simulator(load_scenario(name, changes))
    return simulator.advance(simulator.steps_per_revolution)


@pytest.mark.slow
@pytest.mark.parametrize("vehicle", ["null", "power_car"])
def test_smooth_running_agrees(vehicle: str) -> None:
    causal = one_turn("undamaged", COARSE, f"vehicle={vehicle}")
    paper = one_turn("undamaged", COARSE, f"vehicle={vehicle}", "dynamics=paper")
    assert np.abs(causal.forces - paper.forces).max() < 0.005 * STATIC
    assert np.abs(causal.stresses - paper.stresses).max() < 0.005 * np.abs(causal.stresses).max()


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_full_band_agrees_through_the_impact() -> None:
    scenario = load_scenario("damage_wheel_1", ["dynamics=paper", "max_frequency=10000", "lag_zero=folded"])
    models = load_models(scenario)
    assert isinstance(models.dynamics, PaperModel)
    models.dynamics = replace(models.dynamics, bays=12)  # 0.26 s: the rail is at rest again within 1e-4
    paper = Simulator(scenario, models=models).advance(2713).forces
    causal = one_turn("damage_wheel_1").forces
    assert np.abs(causal.max(axis=0) - paper.max(axis=0)).max() < 0.01 * STATIC
    # the force rises by 70 kN in a step: what a tenth of a step would shift is not held against either
    difference = causal - paper
    assert np.abs(difference[:1750]).max() < 0.005 * STATIC
    assert difference.std(axis=0).max() < 0.005 * STATIC
    assert np.abs(difference).max() < 0.1 * np.abs(np.diff(causal, axis=0)).max()


def test_what_paper_dynamics_cannot_do_is_refused() -> None:
    with pytest.raises(InputError, match="half the sampling frequency"):
        Simulator(load_scenario("undamaged", ["dynamics=paper", "max_frequency=9000", "step_length=0.002"]))
    with pytest.raises(InputError, match="lag_zero"):
        load_scenario("undamaged", ["dynamics=paper", "lag_zero=residual"])
