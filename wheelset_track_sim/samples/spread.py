"""Smallest, median and largest of values that vary from place to place, or from turn to turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .turns import TurnPeaks

MOST_TURNS = 10_000
"""Turns that are kept for a median: of more, every second, fourth, and so on."""


@dataclass(frozen=True)
class Spread:
    """Of some values, in their unit."""

    low: float
    median: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Of at least one value."""
        return cls(float(min(values)), float(np.median(values)), float(max(values)))

    def as_mapping(self) -> dict[str, float]:
        """As commands print it with ``--json``."""
        return {"min": self.low, "median": self.median, "max": self.high}


def spreads(items: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Nested mappings of one form as one of that form, with ``min``, ``median`` and ``max`` in the place of numbers."""
    return {
        key: spreads([item[key] for item in items])
        if isinstance(first, Mapping)
        else Spread.of([item[key] for item in items]).as_mapping()
        for key, first in items[0].items()
    }


class TurnSpread:
    """Spread of the peaks of turns, in bounded memory; smallest and largest are exact."""

    def __init__(self) -> None:
        self.turns = 0
        self._every = 1
        self._kept: list[tuple[float, ...]] = []
        self._ends: list[tuple[float, float]] = []

    def push(self, peaks: TurnPeaks) -> None:
        """Take in a turn."""
        values = (*peaks.forces, *peaks.principal)
        ends = self._ends or [(value, value) for value in values]
        self._ends = [(min(low, value), max(high, value)) for (low, high), value in zip(ends, values, strict=True)]
        if self.turns % self._every == 0:
            self._kept.append(values)
        self.turns += 1
        if len(self._kept) >= 2 * MOST_TURNS:
            self._kept, self._every = self._kept[::2], 2 * self._every

    @property
    def spreads(self) -> tuple[Spread, ...]:
        """Of the largest force of wheel 1 and 2, N, and the largest principal stress of each node, Pa; may be empty."""
        medians = np.median(np.array(self._kept), axis=0) if self._kept else ()
        return tuple(Spread(low, float(middle), high) for (low, high), middle in zip(self._ends, medians, strict=True))
