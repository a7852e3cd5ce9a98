"""Supports that differ along the line: pads and ballast sleeper by sleeper and side by side, hanging sleepers, scatter.

People write what differs from the track, as multiples of its values::

    line:
      bays: 80
      supports:
        - {sleepers: 30-60, over: 8, ballast_stiffness: 4.0}   # a stiff stretch, reached over 8 sleepers
        - {sleepers: 12, on: rail_1, pad_stiffness: 0.5}
        - {sleepers: 20-21, gap: 0.001}                        # two sleepers hang 1 mm above their ballast
      scatter: {pad_stiffness: 0.1, ballast_stiffness: 0.3, seed: 1}

Sleeper 0 stands at x = 0, where step 0 is, and the line repeats after ``bays``. Multiples of several entries, and of
the scatter, multiply; of several gaps the largest holds.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from ..errors import InputError
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real

Rail = Literal["rail_1", "rail_2", "both"]

STIFF, DAMPED = (1e-3, 100.0), (1e-3, 10.0)
"""Limits of the multiples of stiffness and of damping."""

FOLLOWED_STEP = 1.0 / 15000.0
"""Longest step, s, in which a line follows what an impact excites within 1 %; in longer ones it is up to 12 % more."""
LONGEST_STEP = 2.0e-4
"""Longest step, s, in which the bays of a line can be followed: in longer ones impacts come out twice as high, and from
0.3 ms on the force grows without bound."""

_RANGE = re.compile(r"\s*(\d{1,9})\s*(?:-\s*(\d{1,9})\s*)?")


@dataclass(frozen=True)
class Supports:
    """A stretch of sleepers, and what their supports are as multiples of the track's."""

    sleepers: int | str
    """One (``12``), a stretch (``30-60``), or several of them (``3, 12, 30-60``)."""
    on: Rail = "both"
    """Rail whose side of the sleepers it is."""
    over: int = quantity("sleepers", 0, 100, "the length of the ramps beside the stretch", default=0)
    """Sleepers on either side over which the multiples go to 1, in equal ratios; a gap has no ramp."""
    pad_stiffness: float = quantity("", *STIFF, "the pad stiffness as a multiple of the track's", default=1.0)
    pad_damping: float = quantity("", *DAMPED, "the pad damping as a multiple of the track's", default=1.0)
    ballast_stiffness: float = quantity("", *STIFF, "the ballast stiffness as a multiple of the track's", default=1.0)
    ballast_damping: float = quantity("", *DAMPED, "the ballast damping as a multiple of the track's", default=1.0)
    gap: float | None = None
    """Gap (m) between sleeper and ballast, 0 to 0.02: the ballast carries what is pressed into it by more than that,
    and holds nothing that lifts off. Left out, it holds both ways."""

    def __post_init__(self) -> None:
        check(self)
        if self.gap is not None and not 0.0 <= self.gap <= 0.02:
            raise InputError(f"gap = {self.gap:g} m is out of range: give 0 to 0.02 m")
        self.stretches()

    @property
    def sides(self) -> tuple[int, ...]:
        """Sides that are meant, 0 of rail 1 and 1 of rail 2."""
        return {"rail_1": (0,), "rail_2": (1,), "both": (0, 1)}[self.on]

    def stretches(self) -> list[tuple[int, int]]:
        """First and last sleeper of each stretch; raises InputError if ``sleepers`` cannot be read."""
        found = []
        for part in str(self.sleepers).split(","):
            match = _RANGE.fullmatch(part)
            first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
            if last < first:
                raise InputError(
                    f"sleepers = {self.sleepers!r} cannot be read: give one such as 12, a stretch such as 30-60, or "
                    f"several with commas"
                )
            found.append((first, last))
        return found


@dataclass(frozen=True)
class Scatter:
    """Supports that differ at random, each side of each sleeper by itself: coefficients of variation.

    Multiples are log-normal with mean 1: none is negative, and the mean support is that of the track.
    """

    pad_stiffness: float = quantity("", 0.0, 1.0, "the coefficient of variation of the pad stiffness", default=0.0)
    pad_damping: float = quantity("", 0.0, 1.0, "the coefficient of variation of the pad damping", default=0.0)
    ballast_stiffness: float = quantity(
        "", 0.0, 1.0, "the coefficient of variation of the ballast stiffness", default=0.0
    )
    ballast_damping: float = quantity("", 0.0, 1.0, "the coefficient of variation of the ballast damping", default=0.0)
    seed: int = quantity("", 0, 2**31 - 1, "the seed of the scatter", default=1)
    """The same seed gives the same line."""

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class SupportLine:
    """Supports along a line that repeats after a number of bays."""

    bays: int = quantity("", 48, 1000, "the number of bays after which the line repeats", default=80)
    supports: tuple[Supports, ...] = ()
    scatter: Scatter = field(default_factory=Scatter)

    def __post_init__(self) -> None:
        check(self)
        for index, entry in enumerate(self.supports):
            last = max(last for _, last in entry.stretches())
            if last >= self.bays:
                raise InputError(
                    f"supports.{index}.sleepers = {entry.sleepers!r} is beyond the line: give sleepers from 0 to "
                    f"{self.bays - 1}, or more bays"
                )


class Along(NamedTuple):
    """Multiples of the track's values, (bays, 2) each: sleeper by sleeper, on the side of rail 1 and of rail 2."""

    pad_stiffness: Real
    pad_damping: Real
    ballast_stiffness: Real
    ballast_damping: Real
    gap: Real
    """m; NaN where the ballast holds both ways."""


KINDS = Along._fields[:4]


def along(line: SupportLine) -> Along:
    """What a line says of each side of each sleeper; of multiples beyond ``STIFF`` and ``DAMPED`` the limit holds."""
    multiples = {}
    for kind, draws in zip(KINDS, np.random.default_rng(line.scatter.seed).spawn(len(KINDS)), strict=True):
        spread = np.sqrt(np.log1p(getattr(line.scatter, kind) ** 2))
        multiples[kind] = np.exp(spread * draws.standard_normal((line.bays, 2)) - spread**2 / 2)
    gap = np.full((line.bays, 2), np.nan)
    sleepers = np.arange(line.bays)
    for entry in line.supports:
        for first, last in entry.stretches():
            from_middle = np.abs((sleepers - (first + last) / 2 + line.bays / 2) % line.bays - line.bays / 2)
            outside = np.maximum(0.0, from_middle - (last - first) / 2)
            share = np.clip(1.0 - outside / (entry.over + 1), 0.0, 1.0)
            for side in entry.sides:
                for kind in KINDS:
                    multiples[kind][:, side] *= getattr(entry, kind) ** share
                if entry.gap is not None:
                    gap[share == 1.0, side] = np.fmax(gap[share == 1.0, side], entry.gap)
    pads_k, pads_c, beds_k, beds_c = (
        np.clip(multiples[kind], *(STIFF if "stiffness" in kind else DAMPED)) for kind in KINDS
    )
    return Along(pads_k, pads_c, beds_k, beds_c, gap)
