"""Turn a simulator's run into messages: the one pipeline of the node, of ``run --out`` and of ``resimulate --out``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ..bags.messages import (
    FRAME,
    Message,
    State,
    chunk_messages,
    impact_message,
    in_frame,
    sensor_messages,
    state_message,
    wayside_message,
)
from ..bags.run_info import Input, RunInfo
from ..bags.settings import RecordSettings
from ..bags.snapshots import writer_of
from ..bags.tread_damage import damage_fields
from ..runtime.cache import digest
from ..samples.block import SampleBlock
from ..samples.impacts import Impact, ImpactDetector, ImpactSettings
from ..samples.summary import Summary, summarise
from ..samples.turns import TurnPeaks, TurnWatch
from ..sensors.reading import SensorReaders
from ..simulation.simulator import Simulator
from ..wayside.watch import WaysideWatch
from .fatigue_watch import FatigueSettings, FatigueWatch
from .stream import Timing

RUNNING, PAUSED, FAILED = range(3)
"""Status in SimulationState."""
UNPACED = Timing(math.nan, 0.0)
"""Of a run that keeps no time."""


@dataclass(frozen=True)
class Events:
    """Impacts and turns in a block."""

    impacts: list[Impact]
    """Impacts that ended, in this order."""
    turn: TurnPeaks
    """The last complete turn of the wheels."""
    turns: tuple[TurnPeaks, ...] = ()
    """Turns that were completed in the block."""
    fatigue: Message | None = None
    """The latest report of fatigue, if one was due in the block."""


@dataclass(frozen=True)
class BlockMessages:
    """Messages of a block, in their order."""

    states: list[Message]
    """States that begin with the block, each a group of its own; none if nothing has changed."""
    chunk: list[Message]
    """Contact forces, stresses, summary, impacts and passages of detectors, which belong together."""
    events: Events


class RunMessages:
    """Messages of one run, block by block; they do not depend on how the run is cut into blocks.

    A state message describes what is simulated from a step on. It is due at the start, at each revision and at each
    change of the speed's set point or of the recording.
    """

    def __init__(
        self,
        simulator: Simulator,
        *,
        start_ns: int = 0,
        impacts: ImpactSettings | None = None,
        frame: str = FRAME,
        fatigue: FatigueWatch | None = None,
    ) -> None:
        """Begin with the next block of ``simulator``; ``start_ns`` is the time stamp of step 0, ns.

        ``impacts`` defines an impact, ``frame`` is that of all headers, ``fatigue`` counts cycles of the axle.
        """
        self.simulator, self.start_ns, self._frame = simulator, start_ns, frame
        self.detector = ImpactDetector(simulator.steps_per_revolution, simulator.models.tread_origin, impacts)
        self.told = state(simulator)
        """The latest state."""
        self.state_due = False
        """Whether the next block repeats the state though nothing has changed, as in a new file."""
        self.fatigue = fatigue
        """Counts cycles of the axle; None if nobody asked for it."""
        self._turns = TurnWatch(simulator.steps_per_revolution)
        wheel = simulator.steps_per_revolution, simulator.models.tread_origin
        self._sensors = SensorReaders(simulator.scenario.sensors, *wheel)
        scenario = simulator.scenario
        self._wayside = WaysideWatch(scenario.wayside, scenario.track, scenario.step_length, speed=scenario.speed)

    def state(self, *, status: int = RUNNING, message: str = "", recording: str = "") -> Message:
        """The state from the next step on."""
        self.told = dataclasses.replace(state(self.simulator), status=status, message=message, recording=recording)
        return in_frame([state_message(self.told, self.start_ns)], self._frame)[0]

    def push(
        self, block: SampleBlock, summary: Summary, timing: Timing = UNPACED, *, recording: str = ""
    ) -> BlockMessages:
        """Messages of the simulator's latest block, which has this ``summary``; ``recording`` is the path of a bag."""
        states = self._states(block, timing, recording)
        impacts = self.detector.push(block, self.told.axle_load / 2, summary)
        turns = tuple(self._turns.push(block, summary))
        reports = self.fatigue.push(block, self.start_ns) if self.fatigue else []
        events = Events(impacts, self._turns.last, turns, reports[-1] if reports else None)
        chunk = chunk_messages(
            block,
            self.start_ns,
            summary=summary,
            turn=events.turn,
            channels=self._sensors.channels,
            sensed=self._sensors.push(block, self.simulator.in_force.sensors),
            **vars(timing),
        )
        passed = [wayside_message(passage, self.start_ns) for passage in self._wayside.push(block)]
        return BlockMessages(
            in_frame(states, self._frame),
            in_frame([*chunk, *self._impacts(impacts), *passed, *reports], self._frame),
            events,
        )

    def finish(self) -> list[Message]:
        """Impacts that have not ended at the end of the run, as far as they go, and the last samples of sensors."""
        last = [*sensor_messages(self._sensors.finish(), self.start_ns), *self._impacts(self.detector.finish())]
        last += self.fatigue.finish(self.start_ns) if self.fatigue else []
        return in_frame(last, self._frame)

    def _states(self, block: SampleBlock, timing: Timing, recording: str) -> list[Message]:
        told, set_point = self.told, self.simulator.course.at(block.first_step).set_point
        before = told.revision, told.speed_set_point, told.recording
        if (block.revision, set_point, recording) == before and not self.state_due:
            return []
        self.state_due = False
        now = states(self.simulator, block.first_step, told.revision)
        found = [dataclasses.replace(each, recording=recording, **vars(timing)) for each in now]
        self.told = found[-1]
        return [state_message(each, self.start_ns) for each in found]

    def _impacts(self, impacts: list[Impact]) -> list[Message]:
        return [impact_message(impact, self.start_ns) for impact in impacts]


class Push(Protocol):
    """Records the latest block of a simulator."""

    def __call__(self, block: SampleBlock, summary: Summary | None = None) -> None:
        """``summary`` is that of the block, if it is known already."""


@contextmanager
def record(
    path: str | Path,
    simulator: Simulator,
    *,
    start_ns: int = 0,
    settings: RecordSettings | None = None,
    impacts: ImpactSettings | None = None,
    fatigue: FatigueSettings | None = None,
) -> Iterator[Push]:
    """Record a simulator from its next block on; a context manager that leaves a readable bag.

    Parameters
    ----------
    path
        ``FILE.mcap``, or the folder of a bag.
    simulator
        The simulator; call what the context manager yields with each of its blocks and, if it is known, its summary.
    start_ns
        Time stamp of step 0, ns since the epoch.
    settings
        How the run is recorded: bounds, splitting, snapshots.
    impacts
        What makes an impact.
    fatigue
        How the fatigue of the axle is counted; by default it is not.

    Raises
    ------
    InputError
        If the bag exists or cannot be written.
    RecordingError
        If the disk refuses later.

    Examples
    --------
    >>> simulator = Simulator(load_scenario("damage_wheel_1"))
    >>> with record("turn.mcap", simulator) as push:
    ...     push(simulator.advance(2713))
    >>> read_bag("turn.mcap").forces.shape
    (2713, 2)
    """
    watch = FatigueWatch(simulator, fatigue) if fatigue else None
    run = RunMessages(simulator, start_ns=start_ns, impacts=impacts, fatigue=watch)
    with writer_of(Path(path), run_info(simulator), settings or RecordSettings(), start_ns=start_ns) as bag:
        bag.write_messages([run.state()])

        def push(block: SampleBlock, summary: Summary | None = None) -> None:
            found = run.push(block, summary or summarise(block))
            for each in found.states:
                bag.write_messages([each])
            bag.write_messages(found.chunk)

        yield push
        bag.write_messages(run.finish())


def run_info(simulator: Simulator) -> RunInfo:
    """Origin of a simulator's run, with all its inputs so far."""
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
    models = simulator.models
    above = {"vehicle": digest(models.vehicle)} if models.vehicle else {}
    return {"wheelset": digest(models.wheelset), "track": digest(models.track), **above}


def state(simulator: Simulator) -> State:
    """The state from the next step on."""
    return states(simulator, simulator.next_step, after=simulator.revision)[-1]


def states(simulator: Simulator, first_step: int, after: int) -> list[State]:
    """States at ``first_step`` of the latest block, of all changes after revision ``after``; at least the latest.

    Of several changes at one step, each matters: a load that changes twice rises twice, and a ramp of the speed that is
    set twice begins again.
    """
    *earlier, latest = simulator.history
    on, time = simulator.course.at(first_step), simulator.course.time_of(first_step)
    return [
        State(
            first_step=first_step,
            time=time,
            step_period=scenario.step_length / on.speed,
            speed=on.speed,
            speed_set_point=set_point,
            position=first_step * scenario.step_length,
            revision=revision.number,
            axle_load=scenario.axle_load,
            damage=damage_fields(scenario.irregularities),
            scenario_name=scenario.name,
            scenario=scenario.to_yaml(),
            digest=simulator.models.digest(scenario),
        )
        for revision, scenario, set_point in (
            *((each.revision, each.scenario, each.set_point) for each in earlier if each.revision.number > after),
            (latest.revision, simulator.in_force, on.set_point),
        )
    ]
