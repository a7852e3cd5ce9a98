"""The toy of tests/support runs as a wheelset does: what tests find with it is not an accident of its numbers."""

import numpy as np
import pytest

from support.toy import COMPONENTS, STATIC, toy_scenario, toy_simulator
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import scenario_from
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator

LOAD = 98.1e3


@pytest.fixture(scope="module")
def smooth() -> SampleBlock:
    """Ten bays."""
    return toy_simulator().advance(6000)


def test_a_smooth_wheel_bears_the_static_load_with_a_ripple_at_the_sleepers(smooth: SampleBlock) -> None:
    assert smooth.forces.mean(axis=0) == pytest.approx([LOAD, LOAD], rel=1e-3)
    assert (np.abs(smooth.forces - LOAD) < 0.03 * LOAD).all()
    spectrum = np.abs(np.fft.rfft(smooth.forces[:, 0] - LOAD))
    assert spectrum.argmax() == 10


def test_its_stresses_are_the_static_ones(smooth: SampleBlock) -> None:
    expected = np.multiply.outer(np.sum([*STATIC.values()], axis=1) * LOAD, COMPONENTS)
    assert smooth.stresses.mean(axis=0) == pytest.approx(expected, rel=5e-3)
    assert smooth.nodes == tuple(STATIC)


def test_a_defect_strikes_once_a_turn_and_the_load_stays_what_it_is() -> None:
    simulator = toy_simulator(like="damage_wheel_1")
    turn = simulator.steps_per_revolution
    assert turn == 2713
    forces = simulator.advance(20 * turn).forces
    assert forces[5 * turn :].mean(axis=0) == pytest.approx([LOAD, LOAD], rel=5e-3)
    assert forces.min() == 0.0
    for first in range(0, 10 * turn, turn):
        passage = forces[first : first + turn, 0]
        assert 1780 < passage.argmax() < 1900
        assert 2.5 * LOAD < passage.max() < 5 * LOAD
        assert (forces[first : first + turn, 1] > 0.5 * LOAD).all()


def test_a_scenario_file_can_hold_its_wheelset() -> None:
    """Programs that have nothing but the file run it on the track that the file names."""
    scenario = scenario_from(toy_scenario().to_mapping())
    assert scenario == toy_scenario()
    models = load_models(scenario)
    assert models.reduced.node_names == tuple(STATIC)
    assert Simulator(scenario, models=models).advance(600).forces.mean() == pytest.approx(LOAD, rel=2e-3)
