import pytest

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator


@pytest.fixture
def damaged() -> Simulator:
    return Simulator(load_scenario("damage_wheel_1"))


@pytest.fixture
def smooth() -> Simulator:
    return Simulator(load_scenario("undamaged"))
