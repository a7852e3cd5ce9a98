"""Measurements from files: tables of text, and bags with the messages of this package."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Literal

import numpy as np

from ...bags import Bag
from ...bags.folder_files import suffix_of
from ...errors import InputError, warn
from ...inputs.tables import Column, ColumnTable, key, read_table
from ...inputs.units import UNITS, Dimension, names_of, unit_named
from ...runtime.arrays import Real
from ...wheelset.reduced import COMPONENTS
from .measurement import WHEELS, Axis, Measurement
from .plausibility import check_loads

AXES: dict[Dimension, Axis] = {"time": "time", "length": "position"}
"""Axis of the dimension of the first column."""


@dataclass(frozen=True)
class Reading:
    """How a file of measured signals is read where its headings do not say it, or say it wrong."""

    units: Sequence[str] = ()
    """Units of all columns of their dimension, such as ``("ms", "kN")``."""
    positive: Literal["compression", "tension"] = "compression"
    """What a positive force in the file is."""
    offsets: Mapping[str, float] = field(default_factory=dict)
    """Force that is added to that of a wheel, N: the static load where a signal has lost it."""
    columns: Mapping[str, str] = field(default_factory=dict)
    """Columns, by name or number, that hold signals that they are not named after: ``{"wheel_1": "Q left"}``."""

    def __post_init__(self) -> None:
        for unit in self.units:
            if unit_named(unit) not in UNITS:
                raise InputError(f"--unit {unit!r} is not known: give one of {', '.join(UNITS)}")
        for name in self.offsets:
            if name not in WHEELS:
                raise InputError(f"--offset applies to {' or '.join(WHEELS)}, not to {name!r}: give one of these")

    def unit(self, dimension: Dimension) -> str:
        """Unit that is given for a dimension, or empty."""
        given = [unit_named(unit) for unit in self.units if UNITS[unit_named(unit)].dimension == dimension]
        return given[-1] if given else ""


def read_measurement(path: str | Path, reading: Reading | None = None) -> Measurement:
    """Read a measurement from a text file or a bag.

    Parameters
    ----------
    path
        A text file whose first column is the time or the position, with a column for each signal
        (``docs/howto/twin.md``), or a bag, in which forces are ``ContactForces`` and stresses ``AxleStress``.
    reading
        What the headings of a text file do not say.

    Raises
    ------
    InputError
        In one line, with the line of the file, for what cannot be used, and for loads that no wheel has.
    RecordingError
        If a bag cannot be read.
    """
    path = Path(path)
    if path.is_dir() or suffix_of(path):
        return _of_bag(path)
    if not path.exists():
        raise InputError(f"{path} does not exist: give a text file or a bag")
    return _of_table(read_table(path), path, reading or Reading())


def _of_table(table: ColumnTable, path: Path, reading: Reading) -> Measurement:
    axis, scale = _axis(table, reading)
    first = table.columns[0]
    _check_rising(table, first)
    chosen = {id(table.chosen(column, name)): name for name, column in reading.columns.items()}
    signals: dict[str, Real] = {}
    left_out = []
    for column in table.columns[1:]:
        name = chosen.get(id(column)) or _signal(column)
        size = _size(table, column, name, reading)
        if size is None:
            left_out.append(column.heading or "a column without a name")
            continue
        if name in signals:
            raise InputError(f"{path}: {name} comes twice: give each column a name of its own")
        missing = np.flatnonzero(np.isnan(column.values))
        if len(missing):
            raise InputError(f"{table.where(missing[0])}: {name} has no value: give a number, or leave the line out")
        signals[name] = column.values * size
        if name in WHEELS and reading.positive == "tension":
            signals[name] = -signals[name]
        if name in reading.offsets:
            signals[name] = signals[name] + reading.offsets[name]
    if not signals:
        raise InputError(
            f"{path} has no signal that can be used in {table.listed()}: wheel_1 and wheel_2 are forces, give "
            f"{', '.join(names_of('force'))}; other names are of stress nodes, give {', '.join(names_of('stress'))}"
        )
    if left_out:
        warn(
            f"{path}: {', '.join(left_out)} is not used: name a column of forces wheel_1 or wheel_2, and one of "
            "stresses after its node"
        )
    measurement = Measurement(path, axis, first.values * scale, signals, first.origin * Decimal(repr(scale)))
    check_loads(measurement, unit_given=bool(reading.unit("force")))
    return measurement


def _axis(table: ColumnTable, reading: Reading) -> tuple[Axis, float]:
    """Axis of the first column, and the size of its unit, s or m."""
    first = table.columns[0]
    for dimension, axis in AXES.items():
        given = reading.unit(dimension) if first.unit in ("", *names_of(dimension)) else ""
        unit = given or first.unit
        if unit in names_of(dimension) and key(first.name) not in {*AXES.values()} - {axis}:
            return axis, UNITS[unit].size
    raise InputError(
        f"{table.source}: the first column is {first.heading!r}: give time [s] or position [m], or another of "
        f"{', '.join([*names_of('time'), *names_of('length')])}"
    )


def _check_rising(table: ColumnTable, first: Column) -> None:
    rising = np.diff(first.values) > 0.0  # false for what is missing, too
    if not rising.all():
        row = int(np.argmin(rising)) + 1
        before, here = (f"{value + first.origin:.15g}" for value in first.values[row - 1 : row + 1].tolist())
        raise InputError(f"{table.where(row)}: {here} is not after the {before} before it: give an axis that increases")


def _signal(column: Column) -> str:
    """Name of the signal of a column."""
    name = re.sub(r"[\s.-]+", "_", column.name)
    return name.lower() if name.lower() in WHEELS else name


def _size(table: ColumnTable, column: Column, name: str, reading: Reading) -> float | None:
    """Size of the unit of a signal, N or Pa; None if it is neither a force of a wheel nor a stress."""
    if name in WHEELS:
        given = reading.unit("force")
        return UNITS[given].size if given else table.size(column, "force")
    given = reading.unit("stress") if column.unit in ("", *names_of("stress")) else ""
    unit = given or column.unit
    return UNITS[unit].size if unit in names_of("stress") else None


def _of_bag(path: Path) -> Measurement:
    blocks = [*Bag(path).blocks()]
    time = np.concatenate([block.time + np.arange(len(block)) * block.step_period for block in blocks])
    forces, stresses = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("forces", "stresses"))
    signals = dict(zip(WHEELS, forces.T, strict=True))
    principal = np.concatenate([block.max_principal for block in blocks])
    for number, node in enumerate(blocks[0].nodes):
        signals[node] = principal[:, number]
        signals |= {
            f"{node}_{component}": stresses[:, number, index]
            for index, component in enumerate(COMPONENTS)
            if stresses[:, number, index].any()
        }
    return Measurement(path, "time", time, signals)
