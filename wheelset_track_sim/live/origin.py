"""What a bag says of the simulator that it records."""

from __future__ import annotations

from ..bags.inputs import Input
from ..bags.messages import State
from ..bags.run_info import RunInfo
from ..bags.tread_damage import damage_fields
from ..runtime.cache import digest
from ..samples.block import SampleBlock
from ..simulation.changes import Applied
from ..simulation.simulator import Simulator


def run_info(simulator: Simulator) -> RunInfo:
    """Origin of a simulator's run, with all that went in so far."""
    scenario = simulator.in_force
    return RunInfo(
        scenario_name=scenario.name,
        scenario=scenario.to_yaml(),
        digest=simulator.models.digest(scenario),
        sleeper_spacing=simulator.models.track.spacing,
        models=model_digests(simulator),
        inputs=tuple(
            Input(applied.revision.number, applied.revision.step, applied.scenario.to_yaml())
            for applied in simulator.history
        ),
    )


def model_digests(simulator: Simulator) -> dict[str, str]:
    """Digests of the models, as their files describe them."""
    return {"wheelset": digest(simulator.models.wheelset), "track": digest(simulator.models.track)}


def state(simulator: Simulator, block: SampleBlock | None = None, *, recording: str = "") -> State:
    """What is simulated from the first step of ``block`` on, the latest block; without one, from the next step on."""
    first_step = simulator.next_step if block is None else block.first_step
    set_point = simulator.course.at(first_step).set_point
    now = Applied(simulator.history[-1].revision, simulator.in_force, set_point)
    return _state(simulator, first_step, now, recording)


def states(simulator: Simulator, block: SampleBlock, after: int) -> list[State]:
    """The same of every change behind revision ``after``, one at least: of several at one step each counts.

    A load that is changed twice rises twice, and a ramp that is begun twice is begun anew.
    """
    earlier = [found for found in simulator.history[:-1] if found.revision.number > after]
    return [*(_state(simulator, block.first_step, found) for found in earlier), state(simulator, block)]


def _state(simulator: Simulator, first_step: int, of: Applied, recording: str = "") -> State:
    scenario = of.scenario
    on = simulator.course.at(first_step)
    return State(
        first_step=first_step,
        time=simulator.course.time_of(first_step),
        step_period=scenario.step_length / on.speed,
        speed=on.speed,
        speed_set_point=of.set_point,
        position=first_step * scenario.step_length,
        revision=of.revision.number,
        axle_load=scenario.axle_load,
        damage=damage_fields(scenario.irregularities),
        scenario_name=scenario.name,
        scenario=scenario.to_yaml(),
        digest=simulator.models.digest(scenario),
        recording=recording,
    )
