"""Turn blocks of samples into messages and back; bags and the node use the same messages."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.impacts import Impact
from ..samples.summary import Summary, statistics, summarise
from ..samples.turns import NO_TURN, TurnPeaks
from ..sensors.kinds import Placed, StrainGauge
from ..sensors.reading import SensorChunk, peaks
from ..wayside.watch import WaysidePassage
from ..wheelset.reduced import COMPONENTS
from .definitions import serialise
from .irregularities_text import irregularities_text, listed_irregularities
from .tread_damage import FIELDS

FRAME = "track"
"""Frame of all headers, unless a node has a prefix."""
NANOSECOND = 1e-9
SENSORS = "sensor_summary"
"""Topic of the scalars of all sensors."""
FATIGUE = "fatigue"
"""Topic of the fatigue of the axle."""
CHUNK = ("header", "first_step", "time", "step_period", "speed", "position", "revision")
"""Fields that every chunk carries, and a state."""


@dataclass(frozen=True, eq=False)
class Message:
    """A message of the node and of its bag."""

    topic: str
    """Relative to the node, such as ``axle_stress/a1``."""
    kind: str
    """Short type name, such as ``AxleStress``."""
    stamp_ns: int
    fields: dict[str, Any]
    """Values by field: numbers, text, contiguous float64 arrays, mappings for messages inside."""

    @cached_property
    def cdr(self) -> bytes:
        """Bytes for the wire and for the bag, serialised once."""
        return serialise(self.kind, self.fields)

    @property
    def end_ns(self) -> int:
        """End of its samples, ns."""
        span: float = self.fields.get("samples", 0) * self.fields.get("step_period", 0.0)
        return self.stamp_ns + round(span / NANOSECOND)

    def packed(self) -> Message:
        """The same with its arrays in ``cdr`` only, so that messages that wait for a disk hold them once."""
        scalars = {name: value for name, value in self.fields.items() if not isinstance(value, np.ndarray)}
        made = Message(self.topic, self.kind, self.stamp_ns, scalars)
        vars(made)["cdr"] = self.cdr
        return made


@dataclass(frozen=True)
class State:
    """The simulation from a step on: one accepted change, and everything needed to simulate it again."""

    first_step: int
    time: float
    """Simulated time of ``first_step``, s."""
    step_period: float
    speed: float
    speed_set_point: float
    """Speed that is approached, m/s."""
    position: float
    revision: int
    axle_load: float
    damage: tuple[Mapping[str, float], ...]
    """Breakouts alone, as fields of ``TreadDamage``: wheel (1 or 2), kind, a, b, h, angle, y."""
    scenario_name: str
    scenario: str
    """The scenario in force as YAML."""
    digest: str
    status: int = 0
    message: str = ""
    real_time_factor: float = math.nan
    lag: float = 0.0
    recording: str = ""

    @property
    def irregularities(self) -> tuple[Any, ...] | None:
        """All irregularities in force, as plain mappings like those of a scenario file; None if unknown."""
        return listed_irregularities(self.scenario)


def in_frame(messages: Iterable[Message], frame: str) -> list[Message]:
    """The same messages with another ``frame_id`` in their headers; none may be serialised yet."""
    found = [*messages]
    for message in found if frame != FRAME else ():
        message.fields["header"]["frame_id"] = frame
    return found


def stress_topic(node: str) -> str:
    """Topic of a stress node: its name in lower case, with an underscore for characters that ROS names cannot hold."""
    return f"axle_stress/{re.sub('[^a-z0-9_]', '_', node.lower())}"


def chunk_messages(
    block: SampleBlock,
    start_ns: int,
    *,
    real_time_factor: float = math.nan,
    lag: float = 0.0,
    summary: Summary | None = None,
    turn: TurnPeaks = NO_TURN,
    channels: Sequence[str] = (),
    sensed: Sequence[SensorChunk] = (),
) -> list[Message]:
    """Messages of one chunk: contact forces, one stress for each node, summary, what sensors give and its summary.

    ``start_ns`` is the time stamp of step 0, ns; ``summary`` is that of the block if it is known already, ``turn`` the
    last complete turn of the wheels, ``sensed`` what came of the sensors' ``channels`` meanwhile. The values are those
    of the block, bit by bit.
    """
    stamp_ns, chunk = _chunk(block, start_ns)
    summary = summary or summarise(block)
    fields = {**chunk, "samples": summary.samples, "real_time_factor": real_time_factor, "lag": lag}
    for wheel, load in zip(("wheel_1", "wheel_2"), summary.wheels, strict=True):
        fields |= {f"{wheel}_{name}": value for name, value in vars(load).items()}
    fields |= vars(summary.contacts)
    fields["nodes"] = [node.name for node in summary.nodes]
    fields["max_principal_max"] = np.array([node.max_principal for node in summary.nodes])
    fields["max_principal_min"] = np.array([node.min_principal for node in summary.nodes])
    fields["max_principal_mean"] = np.array([node.mean_principal for node in summary.nodes])
    fields["max_principal_rms"] = np.array([node.rms_principal for node in summary.nodes])
    components = statistics(_by_component(block).reshape(-1, len(block)))
    fields |= {f"stress_{name}": value for name, value in components._asdict().items()}
    fields |= {"turns": turn.turns, "turn_max_principal": np.array(turn.principal or [math.nan] * len(block.nodes))}
    fields["wheel_1_turn_max_force"], fields["wheel_2_turn_max_force"] = turn.forces
    summary_message = Message("summary", "LoadSummary", stamp_ns, fields)
    found = [*sample_messages(block, start_ns), summary_message, *sensor_messages(sensed, start_ns)]
    if channels:
        peak, rms = peaks(channels, sensed)
        found.append(
            Message(SENSORS, "SensorSummary", stamp_ns, {**chunk, "names": [*channels], "peak": peak, "rms": rms})
        )
    return found


def sensor_messages(chunks: Iterable[SensorChunk], start_ns: int) -> list[Message]:
    """Messages of what sensors give; ``start_ns`` is the time stamp of step 0, ns."""
    return [sensor_message(chunk, start_ns) for chunk in chunks]


def sensor_message(chunk: SensorChunk, start_ns: int) -> Message:
    """Message of one sensor's samples."""
    stamp_ns, fields = _chunk(chunk, start_ns)
    fields |= {"first_sample": chunk.first_sample, **chunk.values}
    if isinstance(chunk.sensor, (Placed, StrainGauge)):
        fields["name"] = chunk.sensor.name
    if isinstance(chunk.sensor, Placed):
        fields["quantity"] = chunk.sensor.type
    return Message(chunk.topic, chunk.sensor.kind, stamp_ns, fields)


def wayside_message(passage: WaysidePassage, start_ns: int) -> Message:
    """Message of a passage of a detector; its own stamp is that of the last sample, with which it is complete."""
    stamp_ns, fields = _chunk(passage, start_ns)
    reading = passage.reading
    channels = reading.detector.channels
    read, true = ([getattr(verdict, name) for verdict in passage.verdicts] for name in ("read", "true"))
    fields |= {
        "first_sample": 0,
        "detector": reading.detector.name,
        "detector_position": reading.position,
        "channels": [each.name for each in channels],
        "types": [each.type for each in channels],
        "units": [each.unit for each in channels],
        "values": np.ascontiguousarray(reading.values.T).ravel(),
        "mean_force": np.array([each.mean for each in read]),
        "peak_force": np.array([each.peak for each in read]),
        "dynamic_factor": np.array([each.dynamic_factor for each in read]),
        "true_mean_force": np.array([each.mean for each in true]),
        "true_peak_force": np.array([each.peak for each in true]),
    }
    last_ns = stamp_ns + round((len(reading) - 1) * passage.step_period / NANOSECOND)
    return Message(passage.topic, "WaysideReading", last_ns, fields)


def sample_messages(block: SampleBlock, start_ns: int) -> list[Message]:
    """Messages of the samples of a block, which may be decimated: contact forces, one stress for each node."""
    stamp_ns, chunk = _chunk(block, start_ns)
    chunk["decimation"] = block.decimation
    forces = np.ascontiguousarray(block.forces.T)
    largest = np.ascontiguousarray(block.max_principal.T)
    messages = [
        Message("contact_forces", "ContactForces", stamp_ns, {**chunk, "wheel_1": forces[0], "wheel_2": forces[1]})
    ]
    for node, stress, maximum in zip(block.nodes, _by_component(block), largest, strict=True):
        fields = {**chunk, "node": node, **dict(zip(COMPONENTS, stress, strict=True)), "max_principal": maximum}
        messages.append(Message(stress_topic(node), "AxleStress", stamp_ns, fields))
    return messages


def impact_message(impact: Impact, start_ns: int) -> Message:
    """Message of an impact; ``start_ns`` is the time stamp of step 0, ns."""
    stamp_ns, header = _header(impact.time, start_ns)
    fields = {**vars(impact), "wheel": impact.wheel + 1, "dynamic_factor": impact.dynamic_factor, "header": header}
    return Message("impacts", "WheelImpact", stamp_ns, fields)


def fatigue_message(time: float, start_ns: int, fields: Mapping[str, Any]) -> Message:
    """Message of the fatigue of the axle up to a simulated time, s; ``start_ns`` is the time stamp of step 0, ns."""
    stamp_ns, header = _header(time, start_ns)
    return Message(FATIGUE, "Fatigue", stamp_ns, {"header": header, "time": time, **fields})


def state_message(state: State, start_ns: int) -> Message:
    """Message of a state; ``start_ns`` is the time stamp of step 0, ns."""
    stamp_ns, chunk = _chunk(state, start_ns)
    fields = {**vars(state), **chunk, "irregularities": irregularities_text(state.scenario)}
    return Message("state", "SimulationState", stamp_ns, fields)


def state_again(state: Message, chunk: Message, note: str = "") -> Message | None:
    """``state`` repeated at the first step of a ``chunk``, with a ``note`` about the steps before it.

    None if the chunk is of another revision: the state does not hold there.
    """
    if state.fields["revision"] != chunk.fields["revision"]:
        return None
    fields = {**state.fields, **{name: chunk.fields[name] for name in CHUNK}}
    return Message(state.topic, state.kind, chunk.stamp_ns, fields | ({"message": note} if note else {}))


def block_of(forces: Any, stresses: list[Any]) -> SampleBlock:
    """Block from a deserialised ContactForces and the AxleStress of every node for the same chunk."""
    return SampleBlock(
        first_step=forces.first_step,
        time=forces.time,
        step_period=forces.step_period,
        speed=forces.speed,
        position=forces.position,
        revision=forces.revision,
        forces=np.stack([forces.wheel_1, forces.wheel_2], axis=-1),
        stresses=np.array([[getattr(stress, name) for name in COMPONENTS] for stress in stresses])
        .reshape(len(stresses), len(COMPONENTS), len(forces.wheel_1))
        .transpose(2, 0, 1),
        nodes=tuple(stress.node for stress in stresses),
        decimation=forces.decimation,
    )


def state_of(message: Any) -> State:
    """State from a deserialised SimulationState."""
    fields = {name: getattr(message, name) for name in State.__dataclass_fields__ if name != "damage"}
    damage = tuple({name: getattr(item, name) for name in FIELDS} for item in message.damage)
    return State(**fields, damage=damage)


def start_of(message: Any) -> int:
    """Time stamp of step 0, ns, from any deserialised message of a run."""
    stamp, since = message.header.stamp, round(float(message.time) / NANOSECOND)
    return int(stamp.sec) * 10**9 + int(stamp.nanosec) - since


def _by_component(block: SampleBlock) -> Real:
    """Stresses (nodes, 6, samples)."""
    return np.ascontiguousarray(np.moveaxis(block.stresses, 0, -1))


def _chunk(of: SampleBlock | State | SensorChunk | WaysidePassage, start_ns: int) -> tuple[int, dict[str, Any]]:
    """Time stamp, ns, and the fields that every chunk carries."""
    stamp_ns, header = _header(of.time, start_ns)
    return stamp_ns, {
        "header": header,
        "first_step": of.first_step,
        "time": of.time,
        "step_period": of.step_period,
        "speed": of.speed,
        "position": of.position,
        "revision": of.revision,
    }


def _header(time: float, start_ns: int) -> tuple[int, dict[str, Any]]:
    """Time stamp, ns, and header of a message at a simulated time, s."""
    stamp_ns = start_ns + round(time / NANOSECOND)
    seconds, nanoseconds = divmod(stamp_ns, 10**9)
    return stamp_ns, {"stamp": {"sec": seconds, "nanosec": nanoseconds}, "frame_id": FRAME}
