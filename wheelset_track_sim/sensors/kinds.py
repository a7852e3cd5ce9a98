"""Kinds of sensors on the wheelset, by the ``type`` of an entry of ``sensors`` in a scenario.

A sensor has a topic, with messages of one kind; channels, which are the arrays of such a message; and rows that the
reduced wheelset reads for it (``wheelset.sensor_rows``). Detectors beside the track are to be kinds of their own: what
they read follows from forces and positions, not from rows of the wheelset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import ClassVar, TypeAlias

import numpy as np

from ..errors import InputError
from ..inputs.schema import quantity, unknown
from ..runtime.arrays import Real
from ..wheelset.imported import ImportedWheelset
from ..wheelset.kinds import AnyWheelset
from ..wheelset.mesh import wheelset_mesh
from ..wheelset.section_mesh import SectionMesh
from ..wheelset.sensor_rows import (
    FAR,
    AxialStrain,
    BoxMotion,
    NamedMotion,
    PointMotion,
    SensorRow,
    SuspensionReaction,
    nearest_node,
    strain_around,
    strain_rows,
)
from ..wheelset.stress_node import check_free_surface
from ..wheelset.wheelset import Wheelset
from .acquisition import Acquisition, check_name

WHEELS = ("wheel_1", "wheel_2")
BOXES = ("axle_box_1", "axle_box_2")
MOST = 64
"""Sensors of a scenario."""
MOST_ROWS = 256
"""Rows that all of them read."""


class OfBothBoxes:
    """A sensor at each of the axle boxes, next to wheel 1 and to wheel 2."""

    channels: ClassVar[tuple[str, ...]] = WHEELS
    turning: ClassVar[bool] = False

    def signals(self, rows: Real, angles: Real) -> Real:
        """Signals (n, channels) from the values of its rows (n, R)."""
        return rows

    def check_against(self, wheelset: AnyWheelset) -> None:
        """Raise InputError for an imported wheelset without motion of its suspension."""
        if isinstance(wheelset, ImportedWheelset) and not wheelset.modes.suspension:
            raise InputError("needs the lift of the wheelset's modes at the axle boxes: give modes.suspension")


@dataclass(frozen=True)
class AxleBoxAcceleration(OfBothBoxes, Acquisition):
    """Vertical acceleration of both axle boxes, upwards."""

    type: ClassVar[str] = "axle_box_acceleration"
    topic: ClassVar[str] = "axle_box_acceleration"
    kind: ClassVar[str] = "AxleBoxAcceleration"
    unit: ClassVar[str] = "m/s^2"

    range: float | None = quantity("m/s^2", 1.0, 1e6, "the largest acceleration", default=None)
    noise: float = quantity("m/s^2", 0.0, 1e4, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("m/s^2", 0.0, 1e3, "the standard deviation of the drift after a second", default=0.0)

    @property
    def rows(self) -> tuple[SensorRow, ...]:
        """What it reads."""
        return BoxMotion(0, 2), BoxMotion(1, 2)


@dataclass(frozen=True)
class SuspensionForce(OfBothBoxes, Acquisition):
    """Force of both primary suspensions, positive in compression."""

    type: ClassVar[str] = "suspension_force"
    topic: ClassVar[str] = "suspension_force"
    kind: ClassVar[str] = "SuspensionForce"
    unit: ClassVar[str] = "N"

    range: float | None = quantity("N", 1e3, 1e8, "the largest force", default=None)
    noise: float = quantity("N", 0.0, 1e6, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("N", 0.0, 1e6, "the standard deviation of the drift after a second", default=0.0)

    @property
    def rows(self) -> tuple[SensorRow, ...]:
        """What it reads."""
        return SuspensionReaction(0), SuspensionReaction(1)

    def check_against(self, wheelset: AnyWheelset) -> None:
        """Raise InputError for an imported wheelset that does not say its suspension's stiffness."""
        super().check_against(wheelset)
        if isinstance(wheelset, ImportedWheelset):
            assert wheelset.suspension_stiffness > 0.0  # which raises


@dataclass(frozen=True)
class Placed(Acquisition):
    """A sensor of vertical motion at one place: an axle box, a measuring point, or a node by ``y`` and ``r``."""

    name: str = ""
    at: str | None = None
    """``axle_box_1``, ``axle_box_2``, or the name of a measuring point of an imported wheelset."""
    y: float | None = quantity("m", -2.0, 2.0, "the axial position", default=None)
    r: float | None = quantity("m", 0.0, 1.0, "the distance from the axis", default=None)
    angle: float = quantity("rad", -2 * pi, 2 * pi, "the angle from the top, to the front first,", default=0.0)

    channels: ClassVar[tuple[str, ...]] = ("value",)
    turning: ClassVar[bool] = False
    kind: ClassVar[str] = "Motion"
    order: ClassVar[int]
    """Of the rate of the displacement."""
    type: ClassVar[str]

    def __post_init__(self) -> None:
        check_name(self.name)
        super().__post_init__()
        by_place = self.y is not None and self.r is not None
        if (self.at is None) != by_place or (self.y is None) != (self.r is None):
            raise InputError(f"sensor {self.name} needs one place: give at, or y and r")

    @property
    def topic(self) -> str:
        """Where it publishes."""
        return f"{self.type}/{self.name}"

    @property
    def rows(self) -> tuple[SensorRow, ...]:
        """What it reads."""
        if self.at in BOXES:
            return (BoxMotion(BOXES.index(self.at), self.order),)
        if self.at is not None:
            return (NamedMotion(self.at, self.order),)
        assert self.y is not None
        assert self.r is not None
        return (PointMotion(self.y, self.r, self.angle, self.order),)

    def signals(self, rows: Real, angles: Real) -> Real:
        """Signals (n, channels) from the values of its rows (n, R)."""
        return rows

    def check_against(self, wheelset: AnyWheelset) -> None:
        """Raise InputError for a place that the wheelset does not have."""
        imported = wheelset if isinstance(wheelset, ImportedWheelset) else None
        if self.at is not None:
            boxes = BOXES if imported is None or imported.modes.suspension else ()
            points = [point.name for point in imported.measuring_points] if imported else []
            if self.at not in (*boxes, *points):
                raise InputError(unknown("node of this wheelset", f"at = {self.at!r}", self.at, [*boxes, *points]))
        elif imported is not None:
            raise InputError(
                "y and r name a node of the mesh, and an imported wheelset has none: give at, one of its "
                "measuring_points"
            )
        elif isinstance(wheelset, Wheelset):
            assert self.y is not None
            assert self.r is not None
            _, far = nearest_node(_mesh(wheelset), self.y, self.r)
            if far > FAR:
                raise InputError(
                    f"y = {self.y:g} m and r = {self.r:g} m are {far:.3g} m from the nearest node of the wheelset: "
                    f"give a place on it, within {FAR:g} m of a node"
                )


@dataclass(frozen=True)
class Acceleration(Placed):
    """Vertical acceleration of a place, upwards."""

    type: ClassVar[str] = "acceleration"
    unit: ClassVar[str] = "m/s^2"
    order: ClassVar[int] = 2

    range: float | None = quantity("m/s^2", 1.0, 1e6, "the largest acceleration", default=None)
    noise: float = quantity("m/s^2", 0.0, 1e4, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("m/s^2", 0.0, 1e3, "the standard deviation of the drift after a second", default=0.0)


@dataclass(frozen=True)
class Velocity(Placed):
    """Vertical velocity of a place, upwards."""

    type: ClassVar[str] = "velocity"
    unit: ClassVar[str] = "m/s"
    order: ClassVar[int] = 1

    range: float | None = quantity("m/s", 1e-4, 1e3, "the largest velocity", default=None)
    noise: float = quantity("m/s", 0.0, 10.0, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("m/s", 0.0, 10.0, "the standard deviation of the drift after a second", default=0.0)


@dataclass(frozen=True)
class Displacement(Placed):
    """Vertical displacement of a place, upwards, from the unloaded position."""

    type: ClassVar[str] = "displacement"
    unit: ClassVar[str] = "m"
    order: ClassVar[int] = 0

    range: float | None = quantity("m", 1e-6, 1.0, "the largest displacement", default=None)
    noise: float = quantity("m", 0.0, 0.1, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("m", 0.0, 0.1, "the standard deviation of the drift after a second", default=0.0)


@dataclass(frozen=True)
class StrainGauge(Acquisition):
    """Axial strain on the axle's surface, positive in tension: by the contact forces, as stress is."""

    name: str = ""
    y: float = quantity("m", -2.0, 2.0, "the axial position", default=0.0)
    angle: float = quantity("rad", -2 * pi, 2 * pi, "the angle from the top, to the front first,", default=0.0)
    """Of a gauge that turns: where it is when angle 0 of the treads meets the rail."""
    turning: bool = True
    """Whether it turns with the axle, as a gauge that is glued to it; otherwise it is fixed in space."""
    range: float | None = quantity("", 1e-6, 0.1, "the largest strain", default=None)
    noise: float = quantity("", 0.0, 1e-3, "the standard deviation of the white noise of a sample", default=0.0)
    drift: float = quantity("", 0.0, 1e-3, "the standard deviation of the drift after a second", default=0.0)

    type: ClassVar[str] = "strain_gauge"
    kind: ClassVar[str] = "Strain"
    unit: ClassVar[str] = ""
    channels: ClassVar[tuple[str, ...]] = ("strain",)

    def __post_init__(self) -> None:
        check_name(self.name)
        super().__post_init__()

    @property
    def topic(self) -> str:
        """Where it publishes."""
        return f"strain/{self.name}"

    @property
    def rows(self) -> tuple[SensorRow, ...]:
        """What it reads: all harmonics around the axle if it turns, their sum at its angle if not."""
        return strain_rows(self.y) if self.turning else (AxialStrain(self.y, None, self.angle),)

    def signals(self, rows: Real, angles: Real) -> Real:
        """Strain (n, 1) from the values of its rows (n, R), with the axle turned by ``angles`` (n,), rad."""
        if not self.turning:
            return rows
        strain: Real = np.einsum("nh,nh->n", rows, strain_around(self.angle + angles))
        return strain[:, np.newaxis]

    def check_against(self, wheelset: AnyWheelset) -> None:
        """Raise InputError for a place off the axle's free surface."""
        if isinstance(wheelset, ImportedWheelset):
            raise InputError(
                "a strain gauge needs a wheelset by its geometry, and an imported one has stresses at its nodes only: "
                "use output.stress_nodes, or leave the gauge out"
            )
        check_free_surface("y", self.y, wheelset.axle, wheelset.attached)


Sensor: TypeAlias = AxleBoxAcceleration | SuspensionForce | Acceleration | Velocity | Displacement | StrainGauge


def check_sensors(sensors: Sequence[Sensor], wheelset: AnyWheelset, dynamics: str, slowest: float) -> None:
    """Raise InputError, with the dotted key, for sensors that a wheelset cannot have, or that share a topic.

    ``slowest`` is the least rate of the steps, Hz.
    """
    if sensors and dynamics == "paper":
        raise InputError("sensors read the modes of causal dynamics: use causal, or leave them out")
    if len(sensors) > MOST:
        raise InputError(f"sensors has {len(sensors)} entries: give up to {MOST}")
    if (count := len(rows_of(sensors))) > MOST_ROWS:
        raise InputError(f"sensors read {count} rows: give fewer, up to {MOST_ROWS} rows; a gauge that turns reads 7")
    topics = [sensor.topic for sensor in sensors]
    for index, sensor in enumerate(sensors):
        if sensor.topic in topics[:index]:
            raise InputError(f"sensors.{index}: topic {sensor.topic} is that of another sensor: give another name")
        if sensor.rate is not None and sensor.rate > slowest * (1 + 1e-9):
            raise InputError(
                f"sensors.{index}.rate = {sensor.rate:g} Hz has a band above half the {slowest:.6g} steps a second at "
                f"the lowest speed: give up to {slowest:.6g} Hz, or a shorter step_length"
            )
        try:
            sensor.check_against(wheelset)
        except InputError as refusal:
            raise InputError(f"sensors.{index}: {refusal}") from None


def rows_of(sensors: Sequence[Sensor]) -> tuple[SensorRow, ...]:
    """Rows of all sensors, one after the other, each once."""
    return tuple(dict.fromkeys(row for sensor in sensors for row in sensor.rows))


@lru_cache(maxsize=4)
def _mesh(wheelset: Wheelset) -> SectionMesh:
    return wheelset_mesh(wheelset)
