"""Wheelsets of both kinds: by geometry, and imported from another finite-element program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import plain, read, unknown
from ..runtime.progress import Progress
from .harmonics import total_mass
from .imported import ImportedWheelset
from .mesh import wheelset_mesh
from .reduced import ReducedWheelset
from .reduction import reduced_wheelset
from .sensor_rows import SensorRow
from .vehicle import Vehicle
from .wheelset import Wheelset

AnyWheelset = Wheelset | ImportedWheelset
TABLES = ("poles", "lift", "suspension", "modal", "static", "static_lift")
"""Arrays of imported wheelsets that a file may hold as text, a row a line."""
LISTS = ("frequencies", "damping_ratios", "modal_masses", "contacts", "position", "own_weight", "modal_lift")
"""The same without rows."""


def load_wheelset(source: str | Path | Mapping[str, Any]) -> AnyWheelset:
    """Load a wheelset.

    Parameters
    ----------
    source
        Name of a shipped wheelset (``x40``, ``trailer``, ``freight``, ``metro``, ``trailer_calculix``), path of a YAML
        or NumPy file, or a mapping with the keys of such a file.

    Returns
    -------
    Wheelset or ImportedWheelset
        A wheelset by its geometry, or by its modes; the key ``imported`` tells the two apart.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.

    Examples
    --------
    >>> wheelset = load_wheelset("x40")
    >>> receptance(wheelset, [25.0, 85.0]).shape  # by frequency, response, force
    (2, 2, 2)
    >>> [node.name for node in wheelset.stress_nodes]
    ['A1', 'B1', 'C1']
    """
    if isinstance(source, Mapping):
        return read_wheelset(source, "wheelset")
    if str(source) in shipped.names("wheelsets"):
        return _shipped(str(source))
    return read_wheelset(shipped.load_yaml("wheelsets", source), "wheelset")


def read_wheelset(data: Any, where: str) -> AnyWheelset:
    """Wheelset from the name of a shipped one or from a mapping; ``where`` is the key that messages begin with.

    Raises InputError.
    """
    if isinstance(data, (Wheelset, ImportedWheelset)):
        return data
    if isinstance(data, str):
        if data not in shipped.names("wheelsets"):
            raise InputError(unknown("wheelset", f"{where} = {data!r}", data, shipped.names("wheelsets")))
        return _shipped(data)
    if isinstance(data, Mapping) and "imported" in data:
        return read(ImportedWheelset, _with_numbers(data, where), where)
    return read(Wheelset, data, where)


def plain_wheelset(wheelset: AnyWheelset) -> Any:
    """Name of a shipped wheelset, or a mapping of all that a wheelset is; ``read_wheelset`` reads both."""
    if wheelset.name in shipped.names("wheelsets") and wheelset == _shipped(wheelset.name):
        return wheelset.name
    content = plain(wheelset)
    return _with_text(content) if isinstance(wheelset, ImportedWheelset) else content


def with_geometry(wheelset: AnyWheelset) -> Wheelset:
    """Return the wheelset; raises InputError for an imported one, which has no geometry."""
    if isinstance(wheelset, ImportedWheelset):
        raise InputError(f"wheelset {wheelset.name} is imported and has no geometry: give a wheelset that has one")
    return wheelset


@lru_cache(maxsize=8)
def mass_of(wheelset: AnyWheelset) -> float:
    """Mass of either kind with axle boxes, kg."""
    return wheelset.mass if isinstance(wheelset, ImportedWheelset) else total_mass(wheelset, wheelset_mesh(wheelset))


def reduce_wheelset(
    wheelset: AnyWheelset,
    progress: Progress | None = None,
    vehicle: Vehicle | None = None,
    rows: Sequence[SensorRow] = (),
) -> ReducedWheelset:
    """Reduced model of either kind, under a vehicle if there is one; from the cache if it takes long to build.

    ``rows`` are what sensors read, of the kinds that this wheelset has.
    """
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.reduced(vehicle, rows)
    return reduced_wheelset(wheelset, vehicle=vehicle, rows=rows, progress=progress)


def primary_suspension(wheelset: AnyWheelset) -> tuple[float, float]:
    """Stiffness, N/m, and damping, N s/m, of one primary suspension; InputError for modes that do not say it."""
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.suspension_stiffness, wheelset.suspension_damping
    return wheelset.axle_boxes.stiffness, wheelset.axle_boxes.damping


@cache
def _shipped(name: str) -> AnyWheelset:
    return read_wheelset(shipped.load_yaml("wheelsets", name), "wheelset")


def _with_numbers(content: Any, where: str) -> Any:
    """``content`` with its tables, at any depth, as lists of numbers."""
    if isinstance(content, Mapping):
        return {
            key: _numbers(item, f"{where}.{key}", rows=key in TABLES)
            if key in (*TABLES, *LISTS) and isinstance(item, str)
            else _with_numbers(item, f"{where}.{key}")
            for key, item in content.items()
        }
    if isinstance(content, list):
        return [_with_numbers(item, f"{where}.{index}") for index, item in enumerate(content)]
    return content


def _with_text(content: Any) -> Any:
    """``content`` with its tables as text, which YAML reads and writes a thousand times faster than lists."""
    if isinstance(content, Mapping):
        return {
            key: "".join(" ".join(map(repr, row)) + "\n" for row in (item if key in TABLES else [item]))
            if key in (*TABLES, *LISTS) and item
            else _with_text(item)
            for key, item in content.items()
        }
    if isinstance(content, list):
        return [_with_text(item) for item in content]
    return content


def _numbers(text: str, where: str, *, rows: bool) -> list[Any]:
    """Rows of numbers from lines of text, or all its numbers."""
    lines = [line for line in text.splitlines() if line.strip()] if rows else [text]
    try:
        table = [[float(word) for word in line.split()] for line in lines]
    except ValueError as reason:
        raise InputError(f"{where} is not a table of numbers ({reason}): give a row a line") from None
    return table if rows else table[0]
