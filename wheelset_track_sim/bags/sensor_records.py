"""What sensors gave, from the messages of a bag."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..wayside.watch import WaysidePassage
from .bag_reader import BagReader
from .content import ContentError, check_place, checked_span
from .messages import wayside_message
from .window import EVERYTHING, RunWindow

CHANNELS: Mapping[str, tuple[str, ...]] = {
    "AxleBoxAcceleration": ("wheel_1", "wheel_2"),
    "SuspensionForce": ("wheel_1", "wheel_2"),
    "Motion": ("value",),
    "Strain": ("strain", "angle"),
}
"""Arrays of the messages of sensors, by their types."""
WAYSIDE = "WaysideReading"
"""Type of the messages of detectors beside the track."""
UNITS = {"AxleBoxAcceleration": "m/s^2", "SuspensionForce": "N", "Strain": ""}
OF_QUANTITY = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
ANGLE = "angle"
LATE = 1.0
"""Time by which messages of one sensor may come after those of another one, s: filters hold 26 samples back."""


@dataclass(frozen=True, eq=False)
class SensorRecord:
    """Samples of one sensor; ``number`` jumps where the bag has a gap."""

    topic: str
    """Relative to the node, such as ``strain/a1``; true values end in ``/true``."""
    unit: str
    """Of the values, SI; angles are in rad."""
    number: NDArray[np.uint64]
    """Of each sample; counts from 0 at step 0."""
    time: Real
    """Simulated time since step 0, s."""
    position: Real
    """Along the track, m."""
    values: Mapping[str, Real]
    """By channel, SI units: (samples,)."""

    def __len__(self) -> int:
        return len(self.time)

    def unit_of(self, channel: str) -> str:
        """Unit of a channel, SI."""
        return "rad" if channel == ANGLE else self.unit


class SensorPart(NamedTuple):
    """One message of a sensor."""

    topic: str
    unit: str
    first_sample: int
    time: float
    step_period: float
    speed: float
    position: float
    values: Mapping[str, Real]

    @property
    def end(self) -> int:
        """Number of the sample after the last one."""
        return self.first_sample + len(next(iter(self.values.values())))


def sensor_parts(reader: BagReader, window: RunWindow = EVERYTHING) -> Iterator[SensorPart]:
    """Messages of all sensors of a bag in the order of its files, and of little more than a window.

    What a detector beside the track read comes as one part for each type of its channels.

    Damage is reported as ``BagReader`` does.
    """
    kinds = [kind for kind in (*CHANNELS, WAYSIDE) if reader.topics(kind)]
    if not kinds:
        return
    for found in reader.stored(kinds, window):
        topic = found.message.topic
        message = reader.decoded(found) if topic.kind in kinds else None
        if message is not None:
            relative = topic.name.removeprefix(f"{topic.prefix or ''}/")
            for part in reader.made(found, partial(_parts, topic.kind, relative, message)) or ():
                if not reader.disordered and part.time > window.stop + LATE:
                    return
                yield part


def sensor_records(reader: BagReader, window: RunWindow, first: float, end: float) -> dict[str, SensorRecord]:
    """Samples of all sensors of a bag from the simulated time ``first`` to before ``end``, s, by topic.

    ``window`` is the part of the run that has these times.
    """
    parts: dict[str, list[SensorPart]] = {}
    read = window if window.whole else RunWindow(first, end, 0, None)
    for part in sensor_parts(reader, read):
        parts.setdefault(part.topic, []).append(part)
    return {topic: _joined(each, first, end) for topic, each in sorted(parts.items())}


def parts_of(passage: WaysidePassage) -> list[SensorPart]:
    """What a detector read, as a bag has it."""
    return _parts(WAYSIDE, passage.topic, SimpleNamespace(**wayside_message(passage, 0).fields))


def _parts(kind: str, topic: str, message: Any) -> list[SensorPart]:
    if kind == WAYSIDE:
        return _wayside_parts(topic, message)
    channels = CHANNELS[kind]
    checked_span(message, channels)
    values = {name: np.asarray(getattr(message, name)) for name in channels}
    for name, signal in values.items():
        if not np.isfinite(signal).all():
            raise ContentError(f"{name} from sample {message.first_sample} on is not finite")
    unit = UNITS[kind] if kind in UNITS else OF_QUANTITY.get(message.quantity, "")
    place = message.time, message.step_period, message.speed, message.position
    return [SensorPart(topic, unit, int(message.first_sample), *place, values)]


def _wayside_parts(topic: str, message: Any) -> list[SensorPart]:
    check_place(message)
    names, values = message.channels, np.asarray(message.values)
    if not (len(names) == len(message.types) == len(message.units) and len(names) and len(values) % len(names) == 0):
        raise ContentError(
            f"its {len(values)} values are not those of {len(names)} channels with a type and a unit each"
        )
    if not len(values) or not np.isfinite(values).all():
        raise ContentError("its values are none, or not finite")
    place = message.time, message.step_period, message.speed, message.position
    found: dict[str, tuple[str, dict[str, Real]]] = {}
    for name, kind, unit, samples in zip(
        names, message.types, message.units, np.split(values, len(names)), strict=True
    ):
        found.setdefault(kind, (unit, {}))[1][name] = samples
    return [SensorPart(f"{topic}/{kind}", unit, 0, *place, of) for kind, (unit, of) in found.items()]


def _joined(parts: list[SensorPart], first: float, end: float) -> SensorRecord:
    parts = sorted(parts, key=lambda part: part.first_sample)
    within = [np.arange(part.end - part.first_sample, dtype=np.float64) * part.step_period for part in parts]
    time = np.concatenate([part.time + since for part, since in zip(parts, within, strict=True)])
    position = [part.position + since * part.speed for part, since in zip(parts, within, strict=True)]
    number = np.concatenate([np.arange(part.first_sample, part.end, dtype=np.uint64) for part in parts])
    held = (time >= first) & (time < end)
    values = {name: np.concatenate([part.values[name] for part in parts])[held] for name in parts[0].values}
    return SensorRecord(parts[0].topic, parts[0].unit, number[held], time[held], np.concatenate(position)[held], values)
