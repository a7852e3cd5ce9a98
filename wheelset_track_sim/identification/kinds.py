"""Kinds of damage that are told apart, each with its unknown sizes, their ranges, and the irregularity that they make.

Sizes are searched in coordinates z: the logarithm of a length, the value itself of a ratio. Before anything is
measured, each z is equally likely within its range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..inputs.schema import unknown
from ..irregularities import TREAD_HALF_WIDTH, Breakout, Flat, Irregularity
from ..runtime.arrays import Real
from ..scenario.scenario import Wheel

LATERAL = 0.005
"""Standard deviation of the lateral place of a defect against the middle of the contact, m: half a wheelset's play."""


@dataclass(frozen=True)
class Unknown:
    """One size that is looked for."""

    name: str
    """With its SI unit behind it, as in ``--json``."""
    meaning: str
    low: float
    high: float
    logarithmic: bool = True

    @property
    def unit(self) -> str:
        """SI unit, or empty."""
        return "m" if self.name.endswith("_m") else ""

    def coordinate(self, value: float) -> float:
        """Z of a value."""
        return math.log(value) if self.logarithmic else value

    def value(self, z: Real) -> Real:
        """Value at z, within the range."""
        found: Real = np.clip(np.exp(z) if self.logarithmic else z, self.low, self.high)
        return found

    @property
    def bounds(self) -> tuple[float, float]:
        """Range of z."""
        return self.coordinate(self.low), self.coordinate(self.high)


@dataclass(frozen=True)
class DamageKind:
    """A kind of damage."""

    name: str
    meaning: str
    unknowns: tuple[Unknown, ...]
    starts: tuple[tuple[float, ...], ...]
    """Sizes from which a search begins, from small to large, as far as they make different signals."""
    lateral: bool
    """Whether the lateral place matters: what is as wide as the tread has none."""
    make: Callable[[Wheel, Sequence[float], float, float], Irregularity]
    """Of the wheel, sizes, angle of the centre, rad, and lateral place, m."""

    @property
    def bounds(self) -> Real:
        """Ranges of z, (sizes, 2)."""
        return np.array([each.bounds for each in self.unknowns]).reshape(-1, 2)

    def values(self, z: Real) -> list[float]:
        """Sizes at z (sizes,)."""
        return [float(each.value(at)) for each, at in zip(self.unknowns, z, strict=True)]

    def coordinates(self, sizes: Sequence[float]) -> Real:
        """Z of sizes, (sizes,)."""
        return np.array([each.coordinate(size) for each, size in zip(self.unknowns, sizes, strict=True)])


def _flat(wheel: Wheel, sizes: Sequence[float], angle: float, y: float) -> Irregularity:
    return Flat(wheel, length=sizes[0], angle=angle)


def _worn(wheel: Wheel, sizes: Sequence[float], angle: float, y: float) -> Irregularity:
    return Flat(wheel, length=sizes[0], worn_length=sizes[0] * sizes[1], angle=angle)


def _breakout(wheel: Wheel, sizes: Sequence[float], angle: float, y: float) -> Irregularity:
    length, depth, width = sizes
    y = min(abs(y), TREAD_HALF_WIDTH - width / 2)
    return Breakout(wheel, a=length / 2, b=width / 2, h=depth, angle=angle, y=y)


_LENGTH = Unknown("length_m", "length", 0.010, 0.120)

KINDS = {
    kind.name: kind
    for kind in (
        DamageKind(
            "flat",
            "fresh flat",
            (_LENGTH,),
            tuple((length,) for length in (0.015, 0.022, 0.031, 0.042, 0.056, 0.075, 0.1)),
            lateral=False,
            make=_flat,
        ),
        DamageKind(
            "worn_flat",
            "worn flat",
            (
                Unknown("fresh_length_m", "length when it was fresh", 0.010, 0.120),
                Unknown("worn_ratio", "worn length over fresh length", 1.2, 2.5, logarithmic=False),
            ),
            tuple((length, ratio) for length in (0.025, 0.040, 0.055, 0.070, 0.090) for ratio in (1.4, 2.0)),
            lateral=False,
            make=_worn,
        ),
        DamageKind(
            "breakout",
            "breakout",
            (
                Unknown("length_m", "length", 0.010, 0.100),
                Unknown("depth_m", "depth", 0.0001, 0.005),
                Unknown("width_m", "width", 0.008, 0.080),
            ),
            tuple((length, depth, 0.8 * length) for length in (0.018, 0.030, 0.045, 0.065) for depth in (4e-4, 1.5e-3)),
            lateral=True,
            make=_breakout,
        ),
    )
}
"""Kinds with a place on the wheel, by name."""
NONE = "none"
NAMES = (*KINDS, NONE)
ANY = "any"


def kinds_of(names: Sequence[str]) -> tuple[str, ...]:
    """Names of kinds, ``any`` for all of them; raises InputError for one that does not exist."""
    for name in names:
        if name not in (*NAMES, ANY):
            raise InputError(unknown("kind of damage", f"--kind {name!r}", name, [*NAMES, ANY]))
    return NAMES if not names or ANY in names else tuple(dict.fromkeys(names))
