"""What sensors gave in a recorded run, against what they give when it is simulated again, in bounded memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..bags.sensor_records import SensorPart, parts_of
from ..samples.block import SampleBlock
from ..sensors.reading import SensorChunk, SensorReaders
from ..simulation.simulator import Simulator
from ..wayside.watch import WaysideWatch
from .differences import unequal_bits

HELD = 64
"""Messages of a sensor that wait for the other run."""


@dataclass(frozen=True)
class SensorDifference:
    """Of one sensor, over a run."""

    largest: float
    """SI unit of the sensor."""
    channel: str
    time: float
    """Simulated time of the largest difference, s."""


class _Waiting:
    """One sensor: recorded samples that are not simulated yet, or the other way round."""

    def __init__(self) -> None:
        self.recorded: deque[SensorPart] = deque(maxlen=HELD)
        self.simulated: deque[SensorChunk | SensorPart] = deque(maxlen=HELD)
        self.found: SensorDifference | None = None

    def compare(self) -> None:
        while self.recorded and self.simulated:
            ours, theirs = self.recorded[0], self.simulated[0]
            low, high = max(ours.first_sample, theirs.first_sample), min(ours.end, theirs.end)
            if high > low:
                self._samples(ours, theirs, low, high)
            if ours.end <= high or ours.end <= low:
                self.recorded.popleft()
            if theirs.end <= high or theirs.end <= low:
                self.simulated.popleft()

    def _samples(self, ours: SensorPart, theirs: SensorChunk | SensorPart, low: int, high: int) -> None:
        for channel, recorded in ours.values.items():
            one = recorded[low - ours.first_sample : high - ours.first_sample]
            other = theirs.values[channel][low - theirs.first_sample : high - theirs.first_sample]
            unequal = unequal_bits(one, other)
            if unequal.any():
                size = np.where(unequal, np.abs(one - other), -1.0)
                at = int(size.argmax())
                time = ours.time + (low - ours.first_sample + at) * ours.step_period
                if self.found is None or size[at] > self.found.largest:
                    self.found = SensorDifference(float(size[at]), channel, time)


class SensorComparison:
    """Compares the sensors that both the recorded and the simulated run have."""

    def __init__(self, simulator: Simulator, recorded: Iterable[SensorPart]) -> None:
        """``recorded`` are the messages of a bag in their order; they are read as the simulation comes to them."""
        self._simulator = simulator
        wheel = simulator.steps_per_revolution, simulator.models.tread_origin
        self._readers = SensorReaders(simulator.scenario.sensors, *wheel)
        scenario = simulator.scenario
        self._wayside = WaysideWatch(scenario.wayside, scenario.track, scenario.step_length)
        self._recorded: Iterator[SensorPart] = iter(recorded)
        self._next = next(self._recorded, None)
        self._waiting: dict[str, _Waiting] = {}
        self._topics: set[str] = set()

    @property
    def found(self) -> dict[str, SensorDifference | None]:
        """The difference of each sensor of both runs; None if all samples are the same."""
        return {topic: each.found for topic, each in self._waiting.items() if topic in self._topics}

    def push(self, block: SampleBlock) -> None:
        """The block that was simulated last."""
        sensed = self._readers.push(block, self._simulator.in_force.sensors)
        passed = [part for passage in self._wayside.push(block) for part in parts_of(passage)]
        self._take([*sensed, *passed], block.time + len(block) * block.step_period)

    def finish(self) -> None:
        """Compare the last samples."""
        self._take(self._readers.finish(), np.inf)

    def _take(self, chunks: Sequence[SensorChunk | SensorPart], end: float) -> None:
        for chunk in chunks:
            self._topics.add(chunk.topic)
            self._of(chunk.topic).simulated.append(chunk)
        while self._next is not None and self._next.time < end:
            self._of(self._next.topic).recorded.append(self._next)
            self._of(self._next.topic).compare()
            self._next = next(self._recorded, None)
        for each in self._waiting.values():
            each.compare()

    def _of(self, topic: str) -> _Waiting:
        return self._waiting.setdefault(topic, _Waiting())
