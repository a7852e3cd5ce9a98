"""Amounts as people type them, a number and a unit such as ``100 km/h``, and the SI numbers that they stand for.

A unit is a product of powers of named units: ``kN s/m``, ``N/mm^2``, ``cm4``. A text is an amount of a quantity if its
unit has the dimension of the quantity's SI unit. Masses are also loads: they are multiplied by ``GRAVITY``, only where
the quantity is a force in N. The arithmetic is exact until the result is rounded once, so that ``60 mm`` is the same
number as ``0.06``, bit for bit.
"""

from __future__ import annotations

import re
from collections import Counter
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from ..errors import InputError
from .units import ALIASES, UNITS, for_people

GRAVITY = Fraction("9.81")
"""Weight of a mass, N/kg, as everywhere in this package."""
BASES = {
    "length": {"m": 1},
    "angle": {"rad": 1},
    "time": {"s": 1},
    "force": {"kg": 1, "m": 1, "s": -2},
    "stress": {"kg": 1, "m": -1, "s": -2},
    "level": {"dB": 1},
}
"""Powers of base units, by dimension of the units that headings of tables have."""
FURTHER: dict[str, tuple[str, str]] = {
    "mrad": ("0.001", "rad"),
    "min": ("60", "s"),
    "h": ("3600", "s"),
    "kg": ("1", "kg"),
    "g": ("0.001", "kg"),
    "t": ("1000", "kg"),
    "MN": ("1e6", "N"),
    "Hz": ("1", "1/s"),
    "kHz": ("1000", "1/s"),
    "1": ("1", "1"),
    "%": ("0.01", "1"),
    "sleepers": ("1", "sleepers"),
    "sqrtm": ("1", "sqrtm"),
}
"""Units that only values have, not headings (``t`` is the time there): size, and the unit that it is the size in."""
SPELLINGS = ALIASES | {"kmh": "km/h"}
"""Other spellings of whole units, in small letters."""
OTHERS = {
    "m": ("mm", "um", "km"),
    "s": ("ms", "us", "min", "h"),
    "N": ("kN", "t", "kg", "MN"),
    "Pa": ("MPa", "GPa", "kPa"),
    "Pa sqrtm": ("MPa sqrtm",),
    "rad": ("deg", "mrad"),
    "kg": ("t", "g"),
    "Hz": ("kHz",),
    "N/m": ("kN/mm", "kN/m", "N/mm"),
    "N s/m": ("kN s/m", "N s/mm"),
    "N m": ("kN m",),
    "N m/s": ("kN m/s",),
    "kg/m3": ("t/m3", "g/cm3"),
    "m2": ("cm2", "mm2"),
    "m4": ("cm4", "mm4"),
    "": ("%",),
}
"""Units beside SI in which people give quantities, by SI unit, the usual one first."""

Powers = frozenset[tuple[str, int]]
_NUMBER = r"[-+]?(?:\d{1,30}(?:\.\d{0,30})?|\.\d{1,30})(?:[eE][-+]?\d{1,3})?"
_AMOUNT = re.compile(rf"\s*(?P<number>{_NUMBER})\s*(?P<unit>\S.{{0,40}})?\s*")
_FACTOR = re.compile(r"(?P<name>[^\W\d]+|%|1)(?:\^?(?P<power>-?\d))?")
_SIGNS = str.maketrans({"²": "2", "³": "3", "⁴": "4", "µ": "u", "μ": "u", "·": " ", "*": " ", "°": "deg"})
_JOINED = re.compile(r"\b([kM]?N)([ms])\b")
"""``Nm`` and ``kNs``, which people write in one word."""


class Unit(NamedTuple):
    """Size of a unit in SI, and its powers of base units."""

    size: Fraction
    powers: Powers


def amount(text: str, si: str, where: str) -> float:
    """SI number that ``text`` stands for, as an amount of a quantity whose unit is ``si``.

    Raises InputError, which begins with ``where``, for what is not a number, or not one with a unit of that dimension.
    """
    found = _AMOUNT.fullmatch(text)
    if found is None:
        raise InputError(f"{where} = {text!r} is not a number: give one, alone or with its unit{_examples(si)}")
    size = size_of((found["unit"] or si).strip(), si)
    if size is None:
        raise InputError(f"{where} = {text!r} is not in a unit of this quantity: give {listed(si)}")
    try:
        return float(Fraction(found["number"]) * size)
    except OverflowError:
        raise InputError(f"{where} = {text!r} is too large for a number: give a smaller one") from None


def whole_number(text: str) -> int | None:
    """Number of up to nine decimal digits; None for any other text."""
    return int(text) if text.isdecimal() and len(text) < 10 else None


def size_of(name: str, si: str) -> Fraction | None:
    """Size of a unit in ``si``; None if it is not known, or of another dimension."""
    unit, wanted = unit_of(name), unit_of(si)
    assert wanted is not None
    if unit is None:
        return None
    if unit.powers == wanted.powers:
        return unit.size / wanted.size
    return unit.size * GRAVITY if si == "N" and unit.powers == {("kg", 1)} else None


def in_unit(value: float, name: str, si: str) -> str:
    """An SI number as people read it in another unit: ``100 km/h``."""
    size = size_of(name, si)
    assert size is not None
    return f"{value / float(size):.4g} {name}".rstrip()


def others(si: str) -> tuple[str, ...]:
    """Units beside SI in which people give a quantity, the usual one first."""
    usual = for_people(si).name
    return tuple(dict.fromkeys([*([usual] if usual != si else []), *OTHERS.get(si, ())]))


def listed(si: str) -> str:
    """Units in which a quantity can be given, for a message."""
    if not si:
        return "a number without unit, or in %"
    masses = f" (t and kg times {float(GRAVITY):g} m/s^2)" if si == "N" else ""
    return f"a number alone, which is in {si}, or with one of {', '.join([si, *others(si)])}{masses}"


@cache
def unit_of(text: str) -> Unit | None:
    """Unit that a text spells: products and quotients of named units with whole powers; None if it spells none."""
    plain = _JOINED.sub(r"\1 \2", " ".join(text.translate(_SIGNS).split()))
    plain = SPELLINGS.get(plain.lower(), plain)
    parts = plain.split("/")
    if len(parts) > 2 or (plain and not all(parts)):
        return None
    size, powers = Fraction(1), Counter[str]()
    for sign, part in zip((1, -1), parts, strict=False):
        for factor in part.split():
            spelled = _FACTOR.fullmatch(factor)
            named = _named(spelled["name"]) if spelled else None
            if spelled is None or named is None:
                return None
            power = sign * int(spelled["power"] or 1)
            size *= named.size**power
            for base, exponent in named.powers:
                powers[base] += power * exponent
    return Unit(size, frozenset((base, exponent) for base, exponent in powers.items() if exponent))


def _named(name: str) -> Unit | None:
    """A single unit by its name, in any letters if those leave one."""
    known = [*UNITS, *FURTHER]
    alike = [name] if name in known else [each for each in known if each.lower() == name.lower()]
    if len(alike) != 1:
        return None
    (name,) = alike
    if name in UNITS:
        return Unit(Fraction(repr(UNITS[name].size)), frozenset(BASES[UNITS[name].dimension].items()))
    size, of = FURTHER[name]
    if name == of:
        return Unit(Fraction(1), frozenset({(name, 1)} if name != "1" else ()))
    base = unit_of(of)
    assert base is not None
    return Unit(Fraction(size) * base.size, base.powers)


def _examples(si: str) -> str:
    return f", such as 5 {others(si)[0]}" if others(si) else ""
