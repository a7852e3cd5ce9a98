"""What a sensor gives, from the true values at every step: sampled at its own rate, noisy, and bound by its range.

Sampling. Sample k is at the time k / rate since step 0. It is the mean of the steps around it under a windowed sinc,
the low pass of ``samples.decimation``: flat to 80 % of half the rate, 80 dB down from half of it on. So it has no
delay, and is known ``REACH`` samples later. Steps count with their length in time: with the speed they change, and the
sensor's rate does not. At the start and at the end of a run the mean is over the steps that there are.

Noise. White noise and drift, a random walk, belong to the number of a sample (``noise``). They are added after the
filter, as large as they are at the step before the sample; then the range clips.

Every sample follows from the run alone: it has the same bits however the run is cut into blocks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.decimation import REACH
from ..samples.resampling import FINE, response_table
from .acquisition import TRUE
from .kinds import Sensor, StrainGauge
from .noise import Noise
from .reading_kernels import weigh


@dataclass(frozen=True, eq=False)
class SensorChunk:
    """Consecutive samples of one sensor."""

    sensor: Sensor
    topic: str
    first_sample: int
    """Number of the first one; counts from 0 at step 0."""
    first_step: int
    """The step at its time or before it."""
    time: float
    """Of the first sample since step 0, s."""
    step_period: float
    """Time from sample to sample, s."""
    speed: float
    """At the first sample, m/s."""
    position: float
    """Of the first sample, m."""
    revision: int
    values: Mapping[str, Real]
    """By channel, (samples,), SI units."""

    def __len__(self) -> int:
        return len(next(iter(self.values.values())))

    @property
    def end(self) -> int:
        """Number of the sample after the last one."""
        return self.first_sample + len(self)


class _Steps(NamedTuple):
    """Steps that are needed yet, one entry each."""

    number: np.ndarray
    time: Real
    period: Real
    speed: Real
    revision: np.ndarray
    noise: Real
    drift: Real
    signals: Real

    def followed_by(self, others: _Steps) -> _Steps:
        return _Steps(*(np.concatenate(pair) for pair in zip(self, others, strict=True)))

    def since(self, first: int) -> _Steps:
        return _Steps(*(each[first:] for each in self))


class StepClock:
    """Times of steps that do not depend on how a run is cut: of the first step, and on at each step period."""

    def __init__(self) -> None:
        self._step, self._time, self._period = 0, math.nan, math.nan

    def times(self, block: SampleBlock) -> Real:
        """Times (samples,) of a block that follows the last one, s."""
        first, period = block.first_step, block.step_period
        if period != self._period:
            time = block.time if math.isnan(self._time) else self._time + (first - self._step) * self._period
            self._step, self._time, self._period = first, time, period
        since = np.arange(first - self._step, first - self._step + len(block), dtype=np.float64)
        return self._time + since * period


class SensorReader:
    """One sensor on a run: blocks in, its samples out."""

    def __init__(self, sensor: Sensor, steps_per_revolution: int, tread_origin: int, *, true: bool = False) -> None:
        """For wheels of ``steps_per_revolution`` steps, whose angle 0 meets the rail at the step ``tread_origin``.

        With ``true`` it gives the true value at every step.
        """
        self.sensor = sensor
        self.topic = f"{sensor.topic}/{TRUE}" if true else sensor.topic
        self._turn, self._origin = steps_per_revolution, tread_origin
        self._rate, self._range = (None, None) if true else (sensor.rate, sensor.range)
        self._clock, self._steps, self._next = StepClock(), None, 0
        if self._rate is not None:
            key = f"{sensor.seed} {sensor.topic}"
            self._noise = Noise(key, len(sensor.channels), self._rate)

    _steps: _Steps | None

    def push(self, block: SampleBlock, sensor: Sensor) -> list[SensorChunk]:
        """Samples that are complete with a block, which follows the last one; ``sensor`` has its noise and drift."""
        signals = block.sensors[self.sensor.topic]
        number = np.arange(block.first_step, block.first_step + len(block))
        if self._rate is None:
            place = (block.first_step, block.first_step, block.time, block.step_period, block.speed, block.position)
            return [self._chunk(*place, block.revision, signals, number.astype(np.float64))]
        ones = np.ones(len(block))
        new = _Steps(
            number,
            self._clock.times(block),
            block.step_period * ones,
            block.speed * ones,
            np.full(len(block), block.revision),
            sensor.noise * ones,
            sensor.drift * ones,
            np.ascontiguousarray(signals),
        )
        if self._steps is None:
            self._next = math.ceil(new.time[0] * self._rate - 1e-9)
            self._steps = new
        else:
            self._steps = self._steps.followed_by(new)
        return self._read(math.floor(float(self._steps.time[-1]) * self._rate - REACH) + 1)

    def finish(self) -> list[SensorChunk]:
        """The samples up to the last step; the reader is used up."""
        if self._rate is None or self._steps is None:
            return []
        return self._read(math.floor(float(self._steps.time[-1]) * self._rate + 1e-9) + 1)

    def _read(self, end: int) -> list[SensorChunk]:
        """Samples from the next one to ``end - 1``."""
        steps, rate, first = self._steps, self._rate, self._next
        if steps is None or rate is None or end <= first:
            return []
        at = np.arange(first, end) / rate
        reach = REACH / rate
        low = np.searchsorted(steps.time, at - reach)
        high = np.searchsorted(steps.time, at + reach)
        read = np.empty((len(at), steps.signals.shape[1]))
        weigh(steps.time, steps.period, steps.signals, at, low, high, rate, response_table(), FINE, read)
        before = np.maximum(np.searchsorted(steps.time, at + 1e-12, side="right") - 1, 0)
        turned = steps.number[before] + (at - steps.time[before]) / steps.period[before]
        step = before[0]
        since = float(at[0] - steps.time[step])
        period, speed = float(steps.period[step]), float(steps.speed[step])
        number = int(steps.number[step])
        chunk = self._chunk(
            first,
            number,
            float(at[0]),
            1.0 / rate,
            speed,
            number * (period * speed) + since * speed,
            int(steps.revision[step]),
            self._noise.added(first, read, steps.noise[before], steps.drift[before]),
            turned,
        )
        self._next = end
        self._steps = steps.since(int(np.searchsorted(steps.time, end / rate - reach)))
        return [chunk]

    def _chunk(
        self,
        first_sample: int,
        first_step: int,
        time: float,
        period: float,
        speed: float,
        position: float,
        revision: int,
        signals: Real,
        steps: Real,
    ) -> SensorChunk:
        """Samples (n, channels) at the steps (n,), which need not be whole, within the range."""
        if self._range is not None:
            signals = np.clip(signals, -self._range, self._range)
        values = dict(zip(self.sensor.channels, np.ascontiguousarray(signals.T), strict=True))
        if isinstance(self.sensor, StrainGauge):
            turned = (steps - self._origin) % self._turn * (2 * math.pi / self._turn) if self.sensor.turning else 0.0
            values["angle"] = (self.sensor.angle + turned * np.ones(len(signals))) % (2 * math.pi)
        return SensorChunk(
            self.sensor, self.topic, first_sample, first_step, time, period, speed, position, revision, values
        )


class SensorReaders:
    """All sensors of a run, each with its true values too if it records them."""

    def __init__(self, sensors: Iterable[Sensor], steps_per_revolution: int, tread_origin: int) -> None:
        """As of ``SensorReader``."""
        wheel: Any = (steps_per_revolution, tread_origin)
        self._readers = [
            SensorReader(sensor, *wheel, true=true)
            for sensor in sensors
            for true in ((False, True) if sensor.true_value and not sensor.ideal else (False,))
        ]

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of what the sensors give, ``TOPIC/CHANNEL``, without angles and true values."""
        readers = (reader for reader in self._readers if reader.topic == reader.sensor.topic)
        return tuple(f"{reader.topic}/{name}" for reader in readers for name in reader.sensor.channels)

    def push(self, block: SampleBlock, sensors: Iterable[Sensor]) -> list[SensorChunk]:
        """Samples that are complete with a block, which follows the last one; ``sensors`` are those in force in it."""
        now = {sensor.topic: sensor for sensor in sensors}
        return [chunk for reader in self._readers for chunk in reader.push(block, now[reader.sensor.topic])]

    def finish(self) -> list[SensorChunk]:
        """The samples up to the last step; the readers are used up."""
        return [chunk for reader in self._readers for chunk in reader.finish()]


def peaks(channels: Sequence[str], chunks: Iterable[SensorChunk]) -> tuple[Real, Real]:
    """Largest size and root of the mean square of each of the ``channels`` in some chunks; NaN where there is none."""
    found = {
        f"{chunk.topic}/{name}": (np.abs(values).max(), math.sqrt(np.mean(values**2)))
        for chunk in chunks
        for name, values in chunk.values.items()
    }
    both = np.array([found.get(name, (math.nan, math.nan)) for name in channels]).reshape(-1, 2)
    return np.ascontiguousarray(both[:, 0]), np.ascontiguousarray(both[:, 1])
