"""The simulator without ROS on one core: 100 km/h, 1 mm, both contacts, eighteen stresses, full rate, in memory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Measure, group

from wheelset_track_sim.commands.run import CHUNK
from wheelset_track_sim.recording import BagWriter
from wheelset_track_sim.recording.origin import run_info, state
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.block import SampleBlock
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.simulation.summary import combine, summarise

CASES = ("undamaged", "damage_wheel_1", "damage_both")
BLOCKS = 10


def simulated(simulator: Simulator, blocks: int = BLOCKS) -> float:
    return blocks * CHUNK * simulator.step_period


def advancing(simulator: Simulator, each: Callable[[SampleBlock], object], blocks: int = BLOCKS) -> Callable[[], list]:
    return lambda: [each(simulator.advance(CHUNK)) for _ in range(blocks)]


@group("core")
@pytest.mark.parametrize("case", CASES)
def test_advance(measure: Measure, case: str) -> None:
    simulator = Simulator(load_scenario(case))
    measure(advancing(simulator, len), simulated=simulated(simulator), rounds=40)


@group("core")
def test_advance_without_stresses(measure: Measure) -> None:
    simulator = Simulator(load_scenario("damage_wheel_1", ["output.stress_nodes=[]"]))
    measure(advancing(simulator, len), simulated=simulated(simulator), rounds=40)


@group("core")
@pytest.mark.parametrize("case", CASES)
def test_run(measure: Measure, case: str) -> None:
    """As the command does it: blocks and their summaries, maximum principal stresses among them."""
    simulator = Simulator(load_scenario(case))
    summaries = advancing(simulator, summarise)
    measure(lambda: combine(summaries()), simulated=simulated(simulator), rounds=40)


@group("core")
@pytest.mark.parametrize("case", CASES)
def test_run_with_bag(measure: Measure, case: str, tmp_path: Path) -> None:
    simulator = Simulator(load_scenario(case))
    with BagWriter(tmp_path / "run.mcap", run_info(simulator), start_ns=0) as bag:
        bag.write_state(state(simulator))
        write = advancing(simulator, lambda block: (summarise(block), bag.write(block)))
        measure(write, simulated=simulated(simulator), rounds=20)


@group("core")
@pytest.mark.parametrize("case", ["undamaged", "damage_wheel_1"])
def test_solver_in_every_step(measure: Measure, case: str) -> None:
    scenario = load_scenario(case)
    simulator = Simulator(scenario, models=load_models(scenario, tables=False))
    measure(advancing(simulator, len, 2), simulated=simulated(simulator, 2), rounds=10)
