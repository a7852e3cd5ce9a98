"""A stretch of line that has something, with ramps at its ends, or all of the line."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..inputs.schema import Quantity, quantity
from ..runtime.arrays import Real
from .surface import Surface

START = Quantity("m", 0.0, 1e5, "the position where the stretch begins")
RAMP = Quantity("m", 0.0, 100.0, "the length over which it rises and falls at the ends")


def start() -> Any:
    """Field for the position where a stretch begins."""
    return quantity(START.unit, START.low, START.high, START.meaning, default=0.0)


def length() -> Any:
    """Field for the length of a stretch; None is all of the line."""
    return quantity("m", 0.01, 1e4, "the length of the stretch", default=None)


def ramp() -> Any:
    """Field for the length over which heights rise and fall at the ends of a stretch, within it."""
    return quantity(RAMP.unit, RAMP.low, RAMP.high, RAMP.meaning, default=0.1)


def check_stretch(start: float, length: float | None, ramp: float) -> None:
    """Raise InputError for a stretch that makes no sense; a ``length`` of None is all of the line."""
    if length is None:
        if start:
            raise InputError(
                f"start = {start:g} m needs a length: give the length of the stretch, or leave start out for all of "
                "the line"
            )
        return
    if 2 * ramp > length:
        raise InputError(f"ramp = {ramp:g} m at both ends is more than length = {length:g} m: give {length / 2:g} m")


class Part(NamedTuple):
    """The steps of a stretch."""

    first: int
    steps: int
    share: Real
    """Of the full height at each step, (steps,), rising and falling as half a cosine."""


def part_of(surface: Surface, start: float, length: float | None, ramp: float) -> Part:
    """Steps of a stretch on ``surface``; all of it, without ramps, for a ``length`` of None."""
    if length is None:
        return Part(0, surface.steps, np.ones(surface.steps))
    steps = max(1, math.floor(length / surface.dx + 1e-9) + 1)
    inside = np.minimum(np.arange(steps), np.arange(steps)[::-1]) * surface.dx
    share = 0.5 - 0.5 * np.cos(np.pi * np.minimum(inside / ramp, 1.0)) if ramp > 0 else np.ones(steps)
    return Part(surface.at(start), steps, share)
