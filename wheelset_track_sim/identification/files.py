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

FORCE, BOX, STRAIN = "force", "axle_box_acceleration", "strain"
ACCELERATIONS = {"": 1.0, "m/s^2": 1.0, "m/s2": 1.0, "g": 9.81}
"""Units of accelerations in files, m/s^2."""
STRAINS = {"": 1.0, "um/m": 1e-6, "ue": 1e-6}
ANGLES = {"": 1.0, "rad": 1.0, "deg": np.pi / 180}
LOOKED_FOR = (Flat, Breakout, Cluster, Polygon)
"""Damage that a bag's scenario loses: it is what is looked for."""


@dataclass(frozen=True)
class Given:
    """What is known of a file of data beside its samples; None for what the file or a default says."""

    signal: str | None = None
    """``force``, ``axle_box_acceleration``, ``strain``, or of a bag the topic ``strain/NAME``."""
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
    place_y: float | None = None
    """Axial place of a strain gauge, m."""
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
        A text file with the time or the position and signals: ``wheel_1``, ``wheel_2`` (forces), ``box_1``, ``box_2``
        (accelerations), or ``strain`` and ``angle``. Or a bag.
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
    elif signal in (BOX, STRAIN):
        measurement = _of_table(read_table(path), path, signal)
    else:
        raise InputError(unknown("signal", f"--signal {signal!r}", signal, [FORCE, BOX, STRAIN]))
    record = evenly(measurement)
    step = record.step if measurement.axis == "time" else record.step / given.speed
    time = np.arange(len(record.signals), dtype=np.float64) * step
    signals = dict(zip(measurement.signals, record.signals.T, strict=True))
    return _observed(str(path), signal, time, signals, given, given.speed, given.axle_load), None


def _signal_of(path: Path) -> str:
    names = {column.name.lower() for column in read_table(path).columns}
    if "strain" in names:
        return STRAIN
    return BOX if names & {"box_1", "box_2"} else FORCE


def _of_table(table: ColumnTable, path: Path, signal: str) -> Measurement:
    """Accelerations or strains of a text file."""
    units: dict[str, Mapping[str, float]] = (
        {"box_1": ACCELERATIONS, "box_2": ACCELERATIONS} if signal == BOX else {"strain": STRAINS, "angle": ANGLES}
    )
    first = table.columns[0]
    axis: Any = "position" if first.unit in ("m", "mm", "km") else "time"
    signals = {}
    for name, sizes in units.items():
        column = table.find(name)
        if column is None:
            continue
        if column.unit not in sizes:
            raise InputError(
                f"{path}: the unit of {column.heading!r} is not known: give {', '.join(filter(None, sizes))}"
            )
        values = column.values * sizes[column.unit]
        signals[name] = np.unwrap(values) if name == "angle" else values
    if not signals or (signal == STRAIN and len(signals) < 2):
        raise InputError(f"{path} has {table.listed()}: give columns {' and '.join(units)}")
    return Measurement(
        path, axis, first.values * table.size(first, "length" if axis == "position" else "time"), signals
    )


def _of_bag(run: Recording, given: Given) -> tuple[Observation, Scenario | None]:
    """Observation of a recorded run."""
    signal = given.signal or FORCE
    state = run.states[0] if run.states else None
    if signal == FORCE:
        time, signals = run.time, dict(zip(WHEELS, run.forces.T, strict=True))
    elif signal in run.sensors:
        record = run.sensors[signal]
        time = record.time
        signals = dict(record.values)
        if "angle" in signals:
            signals["angle"] = np.unwrap(signals["angle"])
        else:
            signals = {f"box_{number + 1}": values for number, values in enumerate(signals.values())}
    else:
        raise InputError(unknown("signal", f"--signal {signal!r}", signal, [FORCE, *run.sensors]))
    load = given.axle_load or (state.axle_load if state else None)
    if load is None:
        raise InputError(f"{run.path} does not hold the axle load: give --axle-load")
    speed = given.speed or float(np.median(run.speed))
    scenario = _scenario(run)
    place = given.place_y
    kind = STRAIN if "angle" in signals else BOX if "box_1" in signals else FORCE
    if kind == STRAIN and place is None and scenario is not None:
        found = [each for each in scenario.sensors if each.topic == signal.removesuffix("/true")]
        place = getattr(found[0], "y", None) if found else None
    own = dataclasses.replace(given, place_y=place)
    return _observed(str(run.path), kind, time - time[0], signals, own, speed, load), scenario


def _scenario(run: Recording) -> Scenario | None:
    """Scenario of a bag without the damage of its wheels, its sensors kept; None if it holds none."""
    if not run.info.scenario:
        return None
    try:
        with recorded_input():
            found = scenario_from(parse(run.info.scenario, "scenario of the bag", trusted=False))
    except InputError as reason:
        raise RecordingError(f"{run.path} holds a scenario that cannot be used: {reason}") from None
    kept = tuple(each for each in found.irregularities if not isinstance(each, LOOKED_FOR))
    return dataclasses.replace(found, irregularities=kept, speed_plan=(), events=())


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
    if signal == STRAIN:
        if given.place_y is None:
            raise InputError(f"{source} does not say where on the axle the gauge is: give --gauge-y")
        return Observation(
            "strain",
            time,
            signals["strain"],
            wheel=given.wheel or "wheel_1",
            place_y=given.place_y,
            angles=signals["angle"],
            **common,
        )
    named: dict[Wheel, Real] = {
        WHEELS[int(name[-1]) - 1]: values for name, values in signals.items() if name[-2:] in ("_1", "_2")
    }
    if given.wheel is not None and given.wheel not in named:
        raise InputError(f"{source} has no signal of {given.wheel}: give one of {', '.join(named)}")
    larger: list[Wheel] = sorted(named, key=lambda name: -farthest(named[name]))
    wheel = given.wheel or larger[0]
    return Observation("force" if signal == FORCE else "box", time, named[wheel], wheel=wheel, **common)
