"""What a bag says of the simulator that it records."""

from __future__ import annotations

from ..simulation.block import SampleBlock
from ..simulation.simulator import Simulator
from .damage import damage_fields
from .messages import State
from .run_info import RunInfo


def run_info(simulator: Simulator) -> RunInfo:
    """Origin of a simulator's run."""
    scenario = simulator.scenario
    return RunInfo(
        scenario_name=scenario.name,
        scenario=scenario.to_yaml(),
        digest=simulator.digest,
        sleeper_spacing=simulator.models.track.spacing,
    )


def state(simulator: Simulator, block: SampleBlock | None = None, *, recording: str = "") -> State:
    """What is simulated from the first step of ``block`` on, the latest block; without one, from the next step on."""
    scenario = simulator.in_force
    first_step = simulator.next_step if block is None else block.first_step
    on = simulator.course.at(first_step)
    return State(
        first_step=first_step,
        time=simulator.course.time_of(first_step),
        step_period=scenario.step_length / on.speed,
        speed=on.speed,
        speed_set_point=on.set_point,
        position=first_step * scenario.step_length,
        revision=simulator.revision,
        axle_load=scenario.axle_load,
        damage=damage_fields(scenario.irregularities),
        scenario_name=scenario.name,
        scenario=scenario.to_yaml(),
        digest=simulator.digest,
        recording=recording,
    )
