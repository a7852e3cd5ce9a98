"""Numbers of a data set that are drawn: fields of dataclasses that take a number or a distribution."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

from ..errors import InputError
from ..inputs.schema import Quantity, parsed
from ..studies.distributions import Distribution, is_distribution, read_distribution

Drawn: TypeAlias = Distribution | float


def drawn(unit: str, low: float, high: float, meaning: str, *, default: Drawn | None, optional: bool = False) -> Any:
    """Field that takes a number or a distribution within limits; with ``optional``, or nothing."""
    quantity = Quantity(unit, low, high, meaning)

    def read(data: Any, where: str) -> Drawn | None:
        if data is None and optional:
            return None
        if not is_distribution(data):
            value = quantity.number(where, data)
            refusal = quantity.refusal(where, value)
            if refusal:
                raise InputError(f"{refusal}, or a distribution")
            return float(value)
        found = read_distribution(data, unit, where)
        for end in found.values([0.0, 1.0]).tolist():
            if not low * (1 - 1e-12) <= end <= high * (1 + 1e-12) and not math.isclose(end, low, abs_tol=1e-12):
                raise InputError(
                    f"{where} reaches {end:g} {unit}".rstrip()
                    + f", which is out of range: give its low and high from {low:g} to {high:g} {unit}".rstrip()
                )
        return found

    return parsed(read, _plain, default=default)


def _plain(value: Drawn | None) -> Any:
    if not isinstance(value, Distribution):
        return value
    numbers = {name: getattr(value, name) for name in ("mean", "deviation", "low", "high")}
    return {"distribution": value.kind} | {name: number for name, number in numbers.items() if math.isfinite(number)}


def value_of(value: Drawn | None, share: float) -> float:
    """The number with the probability ``share`` of a smaller one; NaN of nothing."""
    if isinstance(value, Distribution):
        return float(value.values([share])[0])
    return math.nan if value is None else value


def highest(value: Drawn) -> float:
    """Upper end."""
    return value_of(value, 1.0)


def lowest(value: Drawn) -> float:
    """Lower end."""
    return value_of(value, 0.0)
