"""Results of a study as xarray holds them: outputs over the axes, with units; in NetCDF and Zarr."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bags.frames import library
from ..version import __version__
from . import drawing
from .evaluate import program
from .outputs import label_of, unit_of

if TYPE_CHECKING:
    from xarray import Dataset

    from .results import Results

DRAW = "draw"
"""Dimension of draws from distributions."""


def dataset(results: Results) -> Dataset:
    """Outputs by axis; values that are drawn are coordinates along ``draw``. Runs that failed are NaN.

    Raises InputError without xarray.
    """
    grid = [axis for axis in results.axes if axis.distribution is None]
    drawn = [axis for axis in results.axes if axis.distribution is not None]
    dimensions = [*(axis.name for axis in grid), *([DRAW] if drawn else [])]
    shape = [len(axis.points) for axis in (*grid, *drawn[:1])]
    coordinates: dict[str, Any] = {}
    for axis in results.axes:
        values = np.array([point.value if axis.is_numeric else point.label for point in axis.points])
        about = {"long_name": axis.meaning} | ({"units": axis.unit} if axis.unit else {})
        coordinates[axis.name] = (DRAW if axis.distribution else axis.name, values, about)
    variables = {
        name: (
            dimensions,
            np.array([results.value(run, name) for run in range(len(results.runs))]).reshape(shape),
            {"long_name": label_of(name), "units": unit_of(name)},
        )
        for name in results.study.outputs
    }
    about = {"title": results.study.title, "made_by": results.made_by, "program": program()}
    found: Dataset = library("xarray").Dataset(variables, coordinates, about | {"wheelset_track_sim": __version__})
    return found


def write_netcdf(results: Results, out: Path) -> Path:
    """Write ``results.nc`` into ``out``, NetCDF 3; raises InputError without xarray."""
    path = out / "results.nc"
    try:
        dataset(results).to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")
    except OSError as reason:
        raise drawing.unwritable(out, reason) from None
    return path


def write_zarr(results: Results, out: Path) -> Path:
    """Write ``results.zarr`` into ``out``; labels of an axis are numbers, with the texts in the attribute ``labels``.

    Raises InputError without xarray and zarr.
    """
    path, found = out / "results.zarr", dataset(results)
    library("zarr")
    for axis in results.axes:
        if not axis.is_numeric:  # Zarr 3 has no texts of a fixed length
            about = found[axis.name].attrs | {"labels": [point.label for point in axis.points]}
            found = found.assign_coords({axis.name: (axis.name, np.arange(len(axis.points)), about)})
    try:
        shutil.rmtree(path, ignore_errors=True)
        found.to_zarr(path, mode="w", consolidated=False)
    except OSError as reason:
        raise drawing.unwritable(out, reason) from None
    return path
