"""The simulator without ROS on one core: 100 km/h, 1 mm, both contacts, eighteen stresses, full rate, in memory."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.conftest import Measure, group
from wheelset_track_sim.cli.run import CHUNK, run
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.simulator import Simulator

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
def test_run(record: Measure, case: str) -> None:
    """The command, with summaries and their maximum principal stresses."""
    record(lambda: by_command(case, None))


@group("core")
@pytest.mark.parametrize("case", CASES)
def test_run_with_bag(record: Measure, case: str, tmp_path: Path) -> None:
    record(lambda: by_command(case, tmp_path / "run.mcap"))


def by_command(
    case: str, out: Path | None, short: float = 1.0, long: float = 7.0, rounds: int = 15
) -> dict[str, float]:
    """Real-time factor by the difference of two durations, s, so that the start does not count."""

    def spent(duration: float) -> float:
        start = time.process_time()
        assert run(case, [], duration, out, json=True) == 0
        found = time.process_time() - start
        if out is not None:
            out.unlink()
        return found

    times = [[spent(duration) for duration in (short, long)] for _ in range(rounds)]
    of_short, of_long = (min(column) for column in zip(*times, strict=True))
    return {"real_time_factor": (long - short) / (of_long - of_short), "simulated_s": long - short}


@group("core")
@pytest.mark.parametrize("case", ["undamaged", "damage_wheel_1"])
def test_solver_in_every_step(measure: Measure, case: str) -> None:
    scenario = load_scenario(case)
    simulator = Simulator(scenario, models=load_models(scenario, tables=False))
    measure(advancing(simulator, len, 2), simulated=simulated(simulator, 2), rounds=10)
