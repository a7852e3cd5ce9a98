"""Recordings as pandas and xarray hold them, with units."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..scenario import WHEELS
from ..wheelset.reduced import COMPONENTS

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from .run_arrays import Recording

ALONG = {"step": "", "position": "m", "speed": "m/s", "revision": ""}
"""What else every sample has, with its unit."""


def dataframe(recording: Recording) -> DataFrame:
    """A row for each step, by simulated time, s; ``attrs`` has the unit of each column and where the run is from."""
    pandas = library("pandas")
    columns, units = columns_of(recording)
    time = columns.pop("time")
    frame = pandas.DataFrame(columns, index=pandas.Index(time, name="time"))
    frame.attrs = {"units": units} | origin(recording)
    return frame


def columns_of(recording: Recording) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """All that is known of each step in columns, the time first, and the unit of each; empty without one."""
    columns: dict[str, Any] = {"time": recording.time} | _along(recording)
    units = {"time": "s"} | ALONG
    for name, force in zip(WHEELS, recording.forces.T, strict=True):
        columns[name], units[name] = force, "N"
    stresses = np.moveaxis(recording.stresses, 0, -1)
    for node, of_node, principal in zip(recording.nodes, stresses, recording.max_principal.T, strict=True):
        found = dict(zip(COMPONENTS, of_node, strict=True)) | {"max_principal": principal}
        columns |= {f"{node}_{component}": stress for component, stress in found.items()}
        units |= {f"{node}_{component}": "Pa" for component in found}
    for topic, record in recording.sensors.items():
        if np.array_equal(record.number, recording.steps):
            for channel, values in record.values.items():
                column = f"{topic}/{channel}".replace("/", "_")
                columns[column], units[column] = values, record.unit_of(channel)
    return columns, units


def sensors_apart(recording: Recording) -> list[str]:
    """Sensors with samples of their own times, which have no place in a table of steps."""
    return [topic for topic, of in recording.sensors.items() if not np.array_equal(of.number, recording.steps)]


def dataset(recording: Recording) -> Dataset:
    """Forces, stresses and maximum principal stress by time, wheel, node and component."""
    xarray = library("xarray")
    coordinates: dict[str, Any] = {
        "time": ("time", recording.time, {"units": "s", "long_name": "simulated time since step 0"}),
        "wheel": ("wheel", list(WHEELS)),
        "node": ("node", list(recording.nodes)),
        "component": ("component", list(COMPONENTS)),
    }
    for name, values in _along(recording).items():
        coordinates[name] = ("time", values, {"units": ALONG[name]} if ALONG[name] else {})
    force = {"units": "N", "long_name": "contact force, positive in compression"}
    principal = {"units": "Pa", "long_name": "maximum principal stress"}
    sensed: dict[str, Any] = {}
    for topic, record in recording.sensors.items():
        name = topic.replace("/", "_")
        own = "time" if np.array_equal(record.number, recording.steps) else f"time_of_{name}"
        if own != "time":
            coordinates[own] = (own, record.time, {"units": "s", "long_name": f"simulated time of {topic}"})
        for channel, values in record.values.items():
            unit = record.unit_of(channel)
            about = {"long_name": f"{topic} {channel}"} | ({"units": unit} if unit else {})
            sensed[f"{name}_{channel}"] = (own, values, about)
    return xarray.Dataset(
        {
            "force": (("time", "wheel"), recording.forces, force),
            "stress": (("time", "node", "component"), recording.stresses, {"units": "Pa", "long_name": "axle stress"}),
            "max_principal": (("time", "node"), recording.max_principal, principal),
            **sensed,
        },
        coords=coordinates,
        attrs=origin(recording),
    )


def _along(recording: Recording) -> dict[str, Any]:
    values = (recording.steps, recording.position, recording.speed, recording.revision)
    return dict(zip(ALONG, values, strict=True))


def origin(recording: Recording) -> dict[str, Any]:
    """Where a run is from, in plain values that files of tables can hold."""
    info = recording.info
    return {
        "scenario": info.scenario_name,
        "digest": info.digest,
        "wheelset_track_sim": info.versions.get("wheelset_track_sim", "unknown"),
        "start_ns": recording.start_ns,
    }


def library(name: str) -> ModuleType:
    """Library of the extra ``analysis``; raises InputError if it is not installed."""
    try:
        return __import__(name)
    except ModuleNotFoundError as missing:
        if missing.name != name:
            raise
        raise InputError(
            f"{name} is not installed: pip install {name}, or this package with the extra analysis"
        ) from None
