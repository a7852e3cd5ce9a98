import pytest

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.block import SampleBlock
from wheelset_track_sim.simulation.simulator import Simulator


@pytest.fixture
def damaged() -> Simulator:
    return Simulator(load_scenario("damage_wheel_1"))


@pytest.fixture
def smooth() -> Simulator:
    return Simulator(load_scenario("undamaged"))


def advance_to(simulator: Simulator, step: int, chunk: int = 1389) -> list[SampleBlock]:
    """Blocks up to ``step``."""
    blocks = []
    while simulator.next_step < step:
        blocks.append(simulator.advance(min(chunk, step - simulator.next_step)))
    return blocks
