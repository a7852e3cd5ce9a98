"""What was measured: signals over time or over the position along the track."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Real = NDArray[np.float64]
Axis = Literal["time", "position"]
UNITS: dict[Axis, str] = {"time": "s", "position": "m"}

SHORTEST = 16
"""Fewest samples of a measurement."""
JITTER = 0.01
"""Share of a step by which samples may stand off an even axis and still count as even."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """Signals by name; the names are those of the simulation.

    ``wheel_1`` and ``wheel_2`` are contact forces in N, positive in compression; the name of a stress node is its
    maximum principal stress, with ``_xx`` to ``_yz`` behind it a component, in Pa.
    """

    source: Path
    axis: Axis
    at: Real
    """(n,) s or m, from any origin, increasing."""
    signals: Mapping[str, Real]
    """(n,) each."""

    def __post_init__(self) -> None:
        if len(self.at) < SHORTEST:
            raise InputError(f"{self.source} has {len(self.at)} samples: give at least {SHORTEST}")
        if not self.signals:
            raise InputError(f"{self.source} has no signal: give wheel_1, wheel_2 or a stress node")

    @property
    def step(self) -> float:
        """From sample to sample, s or m: the mean of all."""
        return float(self.at[-1] - self.at[0]) / (len(self.at) - 1)

    @property
    def even(self) -> bool:
        """Whether the samples stand at even distances."""
        return bool(np.abs(self.at - (self.at[0] + self.step * np.arange(len(self.at)))).max() <= JITTER * self.step)
