"""Units: those that people write in headings of tables and on the command line, and those that people read.

Files for programs are in SI; text and figures for people have the units of the railway.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

Dimension = Literal["length", "angle", "time", "force", "stress", "level"]


class UnitSize(NamedTuple):
    """A unit: what it measures, and its size in SI."""

    dimension: Dimension
    size: float


UNITS: dict[str, UnitSize] = {
    "m": UnitSize("length", 1.0),
    "mm": UnitSize("length", 1e-3),
    "um": UnitSize("length", 1e-6),
    "cm": UnitSize("length", 1e-2),
    "km": UnitSize("length", 1e3),
    "rad": UnitSize("angle", 1.0),
    "deg": UnitSize("angle", math.pi / 180),
    "s": UnitSize("time", 1.0),
    "ms": UnitSize("time", 1e-3),
    "us": UnitSize("time", 1e-6),
    "ns": UnitSize("time", 1e-9),
    "N": UnitSize("force", 1.0),
    "kN": UnitSize("force", 1e3),
    "Pa": UnitSize("stress", 1.0),
    "kPa": UnitSize("stress", 1e3),
    "MPa": UnitSize("stress", 1e6),
    "GPa": UnitSize("stress", 1e9),
    "dB": UnitSize("level", 1.0),
}
ALIASES = {
    "°": "deg",
    "degree": "deg",
    "degrees": "deg",
    "sec": "s",
    "n/mm2": "MPa",
    "n/mm^2": "MPa",
    "n/mm²": "MPa",
    "micron": "um",
    "microns": "um",
    "mikrometer": "um",
    "db re 1 um": "dB",
    "db re 1um": "dB",
    "db re 1 micron": "dB",
}
"""Other spellings, in small letters with ``u`` for the Greek letter of micro."""


class ShownUnit(NamedTuple):
    """A unit that people read, with its size in SI."""

    name: str
    size: float = 1.0


FOR_PEOPLE = {
    "m/s": ShownUnit("km/h", 1 / 3.6),
    **{si: ShownUnit(name, UNITS[name].size) for si, name in (("m", "mm"), ("N", "kN"), ("Pa", "MPa"), ("s", "ms"))},
}
"""What people read in the place of an SI unit; the others are read as they are."""


def unit_named(text: str) -> str:
    """Name of the unit that ``text`` spells, as in ``UNITS``; empty if it spells none."""
    plain = text.strip().replace("\u00b5", "u").replace("\u03bc", "u")
    if plain in UNITS:
        return plain
    small = plain.lower()
    if small in ALIASES:
        return ALIASES[small]
    alike = [name for name in UNITS if name.lower() == small]
    return alike[0] if len(alike) == 1 else ""


def names_of(dimension: Dimension) -> list[str]:
    """Names of the units of a dimension."""
    return [name for name, unit in UNITS.items() if unit.dimension == dimension]


def for_people(si: str) -> ShownUnit:
    """The unit in which people read a quantity of the SI unit ``si``."""
    return FOR_PEOPLE.get(si, ShownUnit(si))


def with_unit(quantity: str, unit: str) -> str:
    """A quantity with its unit, as over a column or along an axis."""
    return f"{quantity} ({unit})" if unit else quantity
