"""Kinds of damage that a data set draws: how often, and how large."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..irregularities import Breakout, Flat, Irregularity
from ..irregularities.breakout import TREAD_HALF_WIDTH
from ..studies.distributions import Distribution
from .drawn import Drawn, drawn, highest, value_of

SIZES = ("length", "worn_length", "a", "b", "h", "y")
"""Sizes of any damage, m, as columns of the labels."""


def _weight() -> Any:
    return quantity("", 0.0, 1e6, "the weight of the kind among all", default=1.0)


@dataclass(frozen=True)
class NoDamage:
    """Rough treads without damage."""

    type: ClassVar[str] = "none"
    half_length: ClassVar[float] = 0.0

    weight: float = _weight()

    def __post_init__(self) -> None:
        check(self)

    def sizes(self, shares: Sequence[float]) -> dict[str, float]:
        """No sizes."""
        return {}


@dataclass(frozen=True)
class FlatDamage:
    """Fresh flats."""

    type: ClassVar[str] = "flat"

    weight: float = _weight()
    length: Drawn = drawn("m", 0.005, 0.15, "length of the flat", default=Distribution("uniform", low=0.015, high=0.06))

    def __post_init__(self) -> None:
        check(self)

    @property
    def half_length(self) -> float:
        """Half of the longest, m."""
        return highest(self.length) / 2

    def sizes(self, shares: Sequence[float]) -> dict[str, float]:
        """Sizes, m, from shares of probability."""
        return {"length": value_of(self.length, shares[0])}


@dataclass(frozen=True)
class WornFlatDamage:
    """Flats with rounded edges."""

    type: ClassVar[str] = "worn_flat"

    weight: float = _weight()
    length: Drawn = drawn(
        "m", 0.005, 0.15, "length of the flat when it was fresh", default=Distribution("uniform", low=0.015, high=0.06)
    )
    growth: Drawn = drawn(
        "", 1.0, 3.0, "the length of the rounded flat over it", default=Distribution("uniform", low=1.2, high=2.0)
    )

    def __post_init__(self) -> None:
        check(self)

    @property
    def half_length(self) -> float:
        """Half of the longest, m."""
        return highest(self.length) * highest(self.growth) / 2

    def sizes(self, shares: Sequence[float]) -> dict[str, float]:
        """Sizes, m, from shares of probability."""
        length = value_of(self.length, shares[0])
        return {"length": length, "worn_length": length * value_of(self.growth, shares[1])}


@dataclass(frozen=True)
class BreakoutDamage:
    """Breakouts of the tread."""

    type: ClassVar[str] = "breakout"

    weight: float = _weight()
    a: Drawn = drawn("m", 0.001, 0.2, "longitudinal semi-axis", default=Distribution("uniform", low=0.008, high=0.035))
    width: Drawn = drawn(
        "", 0.1, 5.0, "the lateral semi-axis over it", default=Distribution("uniform", low=0.5, high=0.9)
    )
    h: Drawn = drawn(
        "m", 0.0, 0.010, "depth", default=Distribution("lognormal", mean=0.6e-3, deviation=0.5e-3, low=1e-4, high=3e-3)
    )
    y: Drawn = drawn(
        "m",
        -TREAD_HALF_WIDTH,
        TREAD_HALF_WIDTH,
        "lateral position from the rolling circle",
        default=Distribution("normal", mean=0.0, deviation=0.005, low=-0.015, high=0.015),
    )

    def __post_init__(self) -> None:
        check(self)
        b, y = highest(self.a) * highest(self.width), max(abs(value_of(self.y, share)) for share in (0.0, 1.0))
        if b + y > TREAD_HALF_WIDTH:
            raise InputError(
                f"a breakout of the lateral semi-axis {b:.3g} m at y = {y:.3g} m leaves the tread: give a, width and y "
                f"so that their largest, |y| + a width, is {TREAD_HALF_WIDTH:g} m at most"
            )

    @property
    def half_length(self) -> float:
        """Half of the longest, m."""
        return highest(self.a)

    def sizes(self, shares: Sequence[float]) -> dict[str, float]:
        """Sizes, m, from shares of probability."""
        a = value_of(self.a, shares[0])
        return {
            "a": a,
            "b": a * value_of(self.width, shares[1]),
            "h": value_of(self.h, shares[2]),
            "y": value_of(self.y, shares[3]),
        }


DamageKind: TypeAlias = NoDamage | FlatDamage | WornFlatDamage | BreakoutDamage


def irregularity(kind: str, on: str, angle: float, sizes: dict[str, float]) -> Irregularity | None:
    """The irregularity of a kind, on a wheel at an ``angle``, rad, with ``sizes``, m; None without damage."""
    wheel: Any = on
    if kind == NoDamage.type:
        return None
    if kind == BreakoutDamage.type:
        return Breakout(wheel, sizes["a"], sizes["b"], sizes["h"], angle, sizes["y"])
    worn = sizes["worn_length"] if kind == WornFlatDamage.type else None
    return Flat(wheel, sizes["length"], worn, angle)
