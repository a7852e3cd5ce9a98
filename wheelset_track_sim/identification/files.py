"""Observations from text files and bags."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..bags.folder_files import suffix_of
from ..bags.run_arrays import Recording, read_bag
from ..errors import InputError, RecordingError, recorded_input
from ..inputs.schema import unknown
from ..inputs.tables import ColumnTable, read_table
from ..inputs.yaml12 import parse
from ..irregularities import Breakout, Cluster, Flat, Polygon
from ..runtime.arrays import Real
from ..scenario import WHEELS, Scenario, scenario_from
from ..scenario.scenario import Wheel
from ..twin.measured import Reading, read_measurement
from ..twin.measured.measurement import Measurement, evenly
from .observation import Observation

FORCE, BOX = "force", "axle_box_acceleration"
ACCELERATIONS = {"": 1.0, "m/s^2": 1.0, "m/s2": 1.0, "g": 9.81}
"""Units of accelerations in files, m/s^2."""
LOOKED_FOR = (Flat, Breakout, Cluster, Polygon)
"""Damage that a scenario loses: it is what is looked for."""


@dataclass(frozen=True)
class Given:
    """What is known of a file of data beside its samples; None for what the file or a default says."""

    signal: str | None = None
    """``force`` or ``axle_box_acceleration``."""
    wheel: Wheel | None = None
    """None for the one with the larger peak."""
    speed: float | None = None
    """m/s"""
    axle_load: float | None = None
    """N"""
    noise: float | None = None
    gain_error: float | None = None
    speed_error: float | None = None
    shape_error: float | None = None
    reading: Reading | None = None
    """How forces are read where the headings do not say it."""

    def further(self) -> dict[str, Any]:
        """What an observation is given as it is."""
        named = ("noise", "gain_error", "speed_error", "shape_error")
        return {name: getattr(self, name) for name in named if getattr(self, name) is not None}


def read_observation(path: str | Path, given: Given | None = None) -> tuple[Observation, Scenario | None]:
    """Observation of a file.

    Parameters
    ----------
    path
        A text file with the time or the position and signals: ``wheel_1`` and ``wheel_2`` (forces), or ``box_1`` and
        ``box_2`` (accelerations). Or a bag.
    given
        What the file does not say.

    Returns
    -------
    Observation
        Of the signal that is asked for, or that is there.
    Scenario or None
        Of a bag, without the damage of its wheels.

    Raises
    ------
    InputError
        For files and signals that cannot be used, and a speed that is missing.
    RecordingError
        For a bag that cannot be read.
    """
    path, given = Path(path), given or Given()
    if path.is_dir() or suffix_of(path):
        return _of_bag(read_bag(path), given)
    if not path.exists():
        raise InputError(f"{path} does not exist: give a text file or a bag")
    if given.speed is None or given.axle_load is None:
        missing = "speed" if given.speed is None else "axle load"
        raise InputError(f"{path} does not hold the {missing}: give --{missing.replace(' ', '-')}")
    signal = given.signal or _signal_of(path)
    if signal == FORCE:
        measurement = read_measurement(path, given.reading)
    elif signal == BOX:
        measurement = _of_table(read_table(path), path)
    else:
        raise InputError(unknown("signal", f"--signal {signal!r}", signal, [FORCE, BOX]))
    record = evenly(measurement)
    step = record.step if measurement.axis == "time" else record.step / given.speed
    time = np.arange(len(record.signals), dtype=np.float64) * step
    signals = dict(zip(measurement.signals, record.signals.T, strict=True))
    return _observed(str(path), signal, time, signals, given, given.speed, given.axle_load), None


def _signal_of(path: Path) -> str:
    names = {column.name.lower() for column in read_table(path).columns}
    return BOX if names & {"box_1", "box_2"} else FORCE


def _of_table(table: ColumnTable, path: Path) -> Measurement:
    """Accelerations of a text file."""
    first = table.columns[0]
    axis: Any = "position" if first.unit in ("m", "mm", "km") else "time"
    signals = {}
    for name in ("box_1", "box_2"):
        column = table.find(name)
        if column is None:
            continue
        if column.unit not in ACCELERATIONS:
            known = ", ".join(filter(None, ACCELERATIONS))
            raise InputError(f"{path}: the unit of {column.heading!r} is not known: give {known}")
        signals[name] = column.values * ACCELERATIONS[column.unit]
    if not signals:
        raise InputError(f"{path} has {table.listed()}: give a column box_1 or box_2")
    size = table.size(first, "length" if axis == "position" else "time")
    return Measurement(path, axis, first.values * size, signals)


def _of_bag(run: Recording, given: Given) -> tuple[Observation, Scenario | None]:
    """Observation of a recorded run."""
    signal = given.signal or FORCE
    if signal == FORCE:
        time, signals = run.time, dict(zip(WHEELS, run.forces.T, strict=True))
    elif signal == BOX and signal in run.sensors:
        record = run.sensors[signal]
        time, signals = record.time, {name: record.values[name] for name in WHEELS}
    else:
        known = [FORCE, *(name for name in run.sensors if name == BOX)]
        raise InputError(unknown("signal", f"--signal {signal!r}", signal, known))
    load = given.axle_load or (run.states[0].axle_load if run.states else None)
    if load is None:
        raise InputError(f"{run.path} does not hold the axle load: give --axle-load")
    speed = given.speed or float(np.median(run.speed))
    return _observed(str(run.path), signal, time - time[0], signals, given, speed, load), _scenario(run)


def _scenario(run: Recording) -> Scenario | None:
    """Scenario of a bag without the damage of its wheels, its sensors kept; None if it holds none."""
    if not run.info.scenario:
        return None
    try:
        with recorded_input():
            found = scenario_from(parse(run.info.scenario, "scenario of the bag", trusted=False))
    except InputError as reason:
        raise RecordingError(f"{run.path} holds a scenario that cannot be used: {reason}") from None
    return without_damage(dataclasses.replace(found, speed_plan=(), events=()))


def without_damage(scenario: Scenario) -> Scenario:
    """The scenario without the damage that is looked for; its rails, roughness and profiles stay."""
    kept = tuple(each for each in scenario.irregularities if not isinstance(each, LOOKED_FOR))
    return dataclasses.replace(scenario, irregularities=kept)


def farthest(values: Real) -> float:
    """Largest distance of a sample from the median."""
    return float(np.abs(values - np.median(values)).max())


def _observed(
    source: str,
    signal: str,
    time: Real,
    signals: Mapping[str, Real],
    given: Given,
    speed: float,
    axle_load: float,
) -> Observation:
    """Observation of the wheel that is given, or has the larger peak."""
    common: dict[str, Any] = {"source": source, "speed": speed, "axle_load": axle_load, **given.further()}
    named: dict[Wheel, Real] = {
        WHEELS[int(name[-1]) - 1]: values for name, values in signals.items() if name[-2:] in ("_1", "_2")
    }
    if given.wheel is not None and given.wheel not in named:
        raise InputError(f"{source} has no signal of {given.wheel}: give one of {', '.join(named)}")
    larger: list[Wheel] = sorted(named, key=lambda name: -farthest(named[name]))
    wheel = given.wheel or larger[0]
    return Observation("force" if signal == FORCE else "box", time, named[wheel], wheel=wheel, **common)
