"""Distributions of a quantity, as axes of a study: uniform, normal, log-normal; whole or between limits.

A value follows from a share ``u`` of probability by the inverse of the distribution function F. Between the limits a
and b of a truncated distribution, it is F^-1(F(a) + u (F(b) - F(a))).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..errors import InputError
from ..inputs import amounts
from ..inputs.schema import unknown
from ..runtime.arrays import Real

Kind = Literal["uniform", "normal", "lognormal"]
PARAMETERS: dict[str, tuple[str, ...]] = {
    "uniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "lognormal": ("mean", "deviation"),
}
"""Kinds of distributions with the parameters that each needs."""
LIMITS = ("low", "high")
EDGE = 2.0**-40
"""Least share of probability on either side, so that every value is finite."""


@dataclass(frozen=True)
class Distribution:
    """A distribution of a quantity; SI units.

    Examples
    --------
    >>> Distribution("normal", mean=30.0, deviation=2.0).values([0.5])
    array([30.])
    """

    kind: Kind
    mean: float = math.nan
    """Of the whole distribution, without limits; NaN if it is uniform."""
    deviation: float = math.nan
    """Standard deviation of the same."""
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise InputError(f"low = {self.low:g} is not below high = {self.high:g}: give low below high")
        if self.kind == "uniform":
            return
        if not self.deviation > 0:
            raise InputError(f"deviation = {self.deviation:g} is out of range: give a standard deviation above 0")
        if self.kind == "lognormal" and not (self.mean > 0 and self.high > 0):
            raise InputError(f"mean = {self.mean:g} cannot be that of a lognormal distribution: give one above 0")

    def values(self, shares: Any) -> Real:
        """Values with the probabilities ``shares`` (n,) of a smaller one; shares from 0 to 1."""
        from scipy.special import ndtr, ndtri

        u = np.clip(np.asarray(shares, dtype=np.float64), EDGE, 1.0 - EDGE)
        if self.kind == "uniform":
            return self.low + u * (self.high - self.low)
        mean, deviation, low, high = self.mean, self.deviation, self.low, self.high
        if self.kind == "lognormal":
            spread = math.log1p((deviation / mean) ** 2)
            mean, deviation = math.log(mean) - spread / 2, math.sqrt(spread)
            low, high = (math.log(limit) if limit > 0 else -math.inf for limit in (low, high))
        first, last = ndtr((np.array([low, high]) - mean) / deviation)
        if not first < last:
            raise InputError(
                f"low = {self.low:g} and high = {self.high:g} leave nothing of the distribution: give limits nearer to "
                f"its mean of {self.mean:g}"
            )
        normal = np.clip(mean + deviation * ndtri(first + u * (last - first)), low, high)
        return np.asarray(np.exp(normal) if self.kind == "lognormal" else normal)


def is_distribution(data: Any) -> bool:
    """Whether plain data names a distribution."""
    return isinstance(data, Mapping) and "distribution" in data


def read_distribution(data: Mapping[str, Any], si: str, where: str) -> Distribution:
    """Distribution of a quantity in ``si`` from plain data; raises InputError that begins with ``where``."""
    kind = data["distribution"]
    if kind not in PARAMETERS:
        raise InputError(unknown("distribution", f"{where}.distribution = {kind!r}", str(kind), [*PARAMETERS]))
    known = tuple(dict.fromkeys([*PARAMETERS[kind], *LIMITS]))
    given: dict[str, float] = {}
    for key, value in data.items():
        if key == "distribution":
            continue
        if key not in known:
            raise InputError(unknown("key", f"{where}.{key}", str(key), ["distribution", *known]))
        given[key] = _number(value, si, f"{where}.{key}")
    for key in PARAMETERS[kind]:
        if key not in given:
            raise InputError(f"{where}.{key} is missing: a {kind} distribution needs {' and '.join(PARAMETERS[kind])}")
    try:
        found = Distribution(kind, **given)
        found.values([0.5])  # refuses limits that leave nothing
    except InputError as refusal:
        raise InputError(f"{where}: {refusal}") from None
    return found


def _number(value: Any, si: str, where: str) -> float:
    if isinstance(value, str):
        return amounts.amount(value, si, where)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InputError(f"{where} = {value!r} is not a finite number: give one, alone or with its unit")
    return float(value)
