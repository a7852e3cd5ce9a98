"""Signals of a recording by name: forces, stresses, and what sensors gave."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, recorded_input
from ..inputs.schema import unknown
from ..inputs.yaml12 import parse
from ..runtime.arrays import Real
from ..samples.resampling import band_limited
from ..scenario import WHEELS, scenario_from
from ..wheelset.reduced import COMPONENTS
from .run_arrays import Recording

STEADY = 1e-6
"""Share by which the time between samples may vary in a signal that is evenly sampled."""


@dataclass(frozen=True, eq=False)
class Signal:
    """One signal of a run."""

    name: str
    unit: str
    """SI."""
    time: Real
    """(n,) simulated time since step 0, s."""
    position: Real
    """(n,) along the track, m."""
    values: Real
    """(n,)"""

    def evenly(self) -> tuple[Real, float]:
        """Values at equal steps of the time, and their rate, Hz; sampled anew if the speed changes."""
        steps = np.diff(self.time)
        if len(steps) == 0:
            raise InputError(f"{self.name} has {len(self.values)} samples: give a longer run")
        longest = float(steps.max())
        mean = float((self.time[-1] - self.time[0]) / len(steps))
        if longest - float(steps.min()) <= STEADY * mean:
            return self.values, 1.0 / mean
        times = np.arange(self.time[0], self.time[-1], longest)
        places = np.interp(times, self.time, np.arange(len(self.time), dtype=np.float64))
        band = max(1.0, float(np.diff(places).max()))
        return band_limited(np.ascontiguousarray(self.values[:, np.newaxis]), places, band)[:, 0], 1.0 / longest


def signal_names(recording: Recording) -> list[str]:
    """Names of all signals of a recording, such as ``wheel_1``, ``A1_yy`` and ``axle_box_acceleration/wheel_1``."""
    stresses = [f"{node}_{part}" for node in recording.nodes for part in (*COMPONENTS, "max_principal")]
    return [*WHEELS, *stresses, *_of_sensors(recording)]


def signal_of(recording: Recording, name: str) -> Signal:
    """Signal of a recording by its name; raises InputError for one that it does not have, or that has gaps."""
    found = _of_sensors_named(recording, name) or _of_steps(recording, name)
    if found is None:
        raise InputError(unknown("signal of this bag", f"signal = {name!r}", name, signal_names(recording)))
    number, signal = found
    jumps = np.flatnonzero(np.diff(number.astype(np.int64)) != 1)
    if len(jumps):
        raise InputError(f"{name} has a gap after {signal.time[jumps[0]]:.4f} s: give --start and --stop beside it")
    return signal


def _of_steps(recording: Recording, name: str) -> tuple[Real, Signal] | None:
    node, _, part = name.partition("_")
    if name in WHEELS:
        values, unit = recording.forces[:, WHEELS.index(name)], "N"
    elif node in recording.nodes and part == "max_principal":
        values, unit = recording.max_principal[:, recording.nodes.index(node)], "Pa"
    elif node in recording.nodes and part in COMPONENTS:
        values, unit = recording.stresses[:, recording.nodes.index(node), COMPONENTS.index(part)], "Pa"
    else:
        return None
    number = recording.steps.astype(np.float64)
    return number, Signal(name, unit, recording.time, recording.position, np.ascontiguousarray(values))


def _of_sensors(recording: Recording) -> Iterator[str]:
    for topic, record in recording.sensors.items():
        yield from (f"{topic}/{channel}" for channel in record.values)


def _of_sensors_named(recording: Recording, name: str) -> tuple[Real, Signal] | None:
    topic, _, channel = name.rpartition("/")
    record = recording.sensors.get(topic)
    if record is None or channel not in record.values:
        return None
    unit = record.unit_of(channel)
    return record.number.astype(np.float64), Signal(name, unit, record.time, record.position, record.values[channel])


def wheel_of(recording: Recording) -> tuple[float, float]:
    """Circumference of the wheels, and the position at which angle 0 of the treads meets the rail, m.

    Raises InputError for a bag whose scenario cannot be read here.
    """
    with recorded_input():
        scenario = scenario_from(parse(recording.info.scenario, "scenario of the bag", trusted=False))
    dx = scenario.step_length
    return scenario.steps_per_revolution * dx, scenario.tread_origin * dx
