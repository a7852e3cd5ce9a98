"""Clusters of breakouts, as rolling contact fatigue leaves them, drawn from distributions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar, Literal, Union, cast

import numpy as np
from numpy.random import Generator

from ..errors import InputError
from ..inputs.amounts import amount
from ..inputs.schema import check, parsed, plain, quantity, quantity_of, value_as
from ..runtime.arrays import Real
from .breakout import Breakout
from .surface import WHEELS, Patch, Surface, check_shape

TRIES = 1000
"""Draws of one breakout until it keeps within the limits of breakouts."""


@dataclass(frozen=True)
class Uniform:
    """Evenly between two values."""

    type: ClassVar[str] = "uniform"

    low: float = quantity("", -10.0, 10.0, "the smallest value")
    high: float = quantity("", -10.0, 10.0, "the largest value")

    def __post_init__(self) -> None:
        check(self)
        if self.high < self.low:
            raise InputError(f"high = {self.high:g} is below low = {self.low:g}: give the larger value as high")

    def draw(self, random: Generator) -> float:
        """One value."""
        return float(random.uniform(self.low, self.high))


@dataclass(frozen=True)
class Normal:
    """Gauss's distribution."""

    type: ClassVar[str] = "normal"

    mean: float = quantity("", -10.0, 10.0, "the mean")
    deviation: float = quantity("", 0.0, 10.0, "the standard deviation")

    def __post_init__(self) -> None:
        check(self)

    def draw(self, random: Generator) -> float:
        """One value."""
        return float(random.normal(self.mean, self.deviation))


@dataclass(frozen=True)
class LogNormal:
    """The logarithm has Gauss's distribution: sizes of many small defects and few large ones."""

    type: ClassVar[str] = "lognormal"

    median: float = quantity("", 1e-6, 10.0, "the median")
    spread: float = quantity("", 0.0, 3.0, "the standard deviation of the natural logarithm")

    def __post_init__(self) -> None:
        check(self)

    def draw(self, random: Generator) -> float:
        """One value."""
        return float(self.median * np.exp(random.normal(0.0, self.spread)))


Distribution = Union[float, Uniform, Normal, LogNormal]  # noqa: UP007  read at run time by schema
"""Of a quantity in its own unit; a number is always that number."""
IN_UNIT = ("low", "high", "mean", "deviation", "median")
"""Numbers of a distribution that have the unit of its quantity."""


def _read(name: str, data: Any, where: str) -> Distribution:
    """Distribution of a quantity of breakouts, from plain data."""
    of = quantity_of(Breakout, name)
    if isinstance(data, Mapping):
        data = {
            key: amount(item, of.unit, f"{where}.{key}") if key in IN_UNIT and isinstance(item, str) else item
            for key, item in data.items()
        }
    return cast(Distribution, value_as(Distribution, of.number(where, data), where))


def _distribution(name: str, **options: Any) -> Any:
    return parsed(partial(_read, name), plain, **options)


@dataclass(frozen=True)
class Cluster:
    """``number`` breakouts (Eq. 22) whose sizes and places are drawn one by one with a ``seed``.

    A breakout out of the limits of ``Breakout`` is drawn again, so distributions are cut off there.
    """

    type: ClassVar[str] = "cluster"

    on: Literal["wheel_1", "wheel_2"]
    a: Distribution = _distribution("a")
    """Longitudinal semi-axis, m."""
    b: Distribution = _distribution("b")
    """Lateral semi-axis, m."""
    h: Distribution = _distribution("h")
    """Depth, m."""
    number: int = quantity("", 1, 1000, "the number of breakouts")
    angle: Distribution = _distribution("angle", default=Uniform(0.0, 2 * np.pi))
    """Of the centre, rad, in the order in which the tread meets the rail."""
    y: Distribution = _distribution("y", default=0.0)
    """Lateral position of the centre from the rolling circle, m."""
    seed: int = quantity("", 0, 2**32 - 1, "the seed of the draws", default=0)

    def __post_init__(self) -> None:
        check_shape(self, WHEELS)
        for name in ("a", "b", "h", "angle", "y"):
            value = getattr(self, name)
            if not isinstance(value, (Uniform, Normal, LogNormal)):
                refusal = quantity_of(Breakout, name).refusal(name, value)
                if refusal:
                    raise InputError(refusal)
        _ = self.breakouts

    @cached_property
    def breakouts(self) -> tuple[Breakout, ...]:
        """The breakouts, in the order in which they were drawn."""
        random = np.random.default_rng(self.seed)
        return tuple(self._breakout(random) for _ in range(self.number))

    def patches(self, surface: Surface, y: Real) -> Iterable[Patch]:
        """Heights on ``surface`` at lateral positions ``y``, m."""
        for breakout in self.breakouts:
            yield from breakout.patches(surface, y)

    def _breakout(self, random: Generator) -> Breakout:
        refusal = ""
        for _ in range(TRIES):
            size: dict[str, Any] = {name: _drawn(getattr(self, name), random) for name in ("a", "b", "h", "angle", "y")}
            try:
                return Breakout(on=self.on, **size)
            except InputError as reason:
                refusal = str(reason)
        raise InputError(f"none of {TRIES} random draws is a valid breakout; the last one: {refusal}")


def _drawn(distribution: Distribution, random: Generator) -> float:
    return float(distribution) if isinstance(distribution, (int, float)) else distribution.draw(random)
