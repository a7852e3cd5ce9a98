"""What was measured: signals over time or over the position along the track."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import scipy

from ...errors import InputError
from ...runtime.arrays import Real
from ...samples.resampling import band_limited

Axis = Literal["time", "position"]
UNITS: dict[Axis, str] = {"time": "s", "position": "m"}
WHEELS = ("wheel_1", "wheel_2")

SHORTEST = 16
"""Fewest samples of a measurement."""
JITTER = 0.01
"""Share of a step by which samples may stand off an even axis and still count as even."""
ROUNDED = 0.6
"""Share of their last digit by which rounded places may stand off the even axis that they were: half, and a little for
the line that is laid through them."""
DIGITS = range(-3, 10)
"""Decimal places that are looked for."""
WHOLE = 0.01
"""How far a number is off a whole one at most: seconds since 1970 have no more digits."""
WIDEST = 3.0
"""Steps between two samples of an uneven axis at most: more is a gap."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """Signals by name; the names are those of the simulation.

    ``wheel_1`` and ``wheel_2`` are contact forces in N, positive in compression; the name of a stress node is its
    maximum principal stress, with ``_xx`` to ``_yz`` behind it a component, in Pa. InputError for too few samples, for
    numbers that are not finite and an axis that does not increase.
    """

    source: Path
    axis: Axis
    at: Real
    """(n,) s or m from ``origin`` on, increasing."""
    signals: Mapping[str, Real]
    """(n,) each."""
    origin: Decimal = Decimal(0)
    """What is taken off time stamps that count from far away, exactly: s since 1970, for example."""

    def __post_init__(self) -> None:
        if len(self.at) < SHORTEST:
            raise InputError(
                f"{self.source} has {len(self.at)} samples of {self.axis} and of {', '.join(self.signals)}: give at "
                f"least {SHORTEST} of each"
            )
        if not self.signals:
            raise InputError(f"{self.source} has no signal: give wheel_1, wheel_2 or a stress node")
        for name, values in {self.axis: self.at, **self.signals}.items():
            if len(lost := np.flatnonzero(~np.isfinite(values))):
                raise InputError(
                    f"{self.source}: {name} of sample {lost[0]} is {values[lost[0]]}: give finite numbers, or a part "
                    "that has them"
                )
        back = np.flatnonzero(np.diff(self.at) <= 0)
        if len(back):
            raise InputError(
                f"{self.source}: {self.axis} of sample {back[0] + 1} is not greater than the one before it: give an "
                "axis that increases"
            )

    @property
    def step(self) -> float:
        """From sample to sample, s or m: the mean of all."""
        return float(self.at[-1] - self.at[0]) / (len(self.at) - 1)

    @property
    def even(self) -> bool:
        """Whether the samples stand at even distances."""
        return bool(np.abs(self.at - (self.at[0] + self.step * np.arange(len(self.at)))).max() <= JITTER * self.step)

    def even_line(self) -> tuple[float, float] | None:
        """Start and step, s or m, of the even axis on which the samples stand, or stood before it was rounded.

        A record of 8000 samples a second with four decimals has steps of 0.1 and 0.2 ms, and was sampled evenly. None
        if it was not.
        """
        if self.even:
            return float(self.at[0]), self.step
        count = np.arange(len(self.at)) - (len(self.at) - 1) / 2
        middle = float(self.at.mean())
        step = float(count @ (self.at - middle)) / float(count @ count)
        off = float(np.abs(self.at - (middle + step * count)).max())
        return (middle + step * float(count[0]), step) if off <= ROUNDED * self._last_digit() else None

    def _last_digit(self) -> float:
        """The largest power of ten below a step that all places are multiples of, s or m; 0 if there is none."""
        for digits in DIGITS:
            scaled = self.at * 10.0**digits
            if 10.0**-digits < self.step and np.abs(scaled - np.round(scaled)).max() < WHOLE:
                return float(10.0**-digits)
        return 0.0


class Even(NamedTuple):
    """Signals at even distances."""

    start: float
    """s or m"""
    step: float
    """s or m"""
    signals: Real
    """(n, signals)"""

    def count(self, step: float) -> int:
        """Samples that it has with another step, s or m, from its first one on."""
        return math.floor((len(self.signals) - 1) * self.step / step + 1e-9) + 1

    def at(self, places: Real, step: float) -> Real:
        """Signals at ``places`` (m,), s or m from the first one, in the band of a coarser ``step``: (m, signals)."""
        return band_limited(self.signals, places / self.step, step / self.step)


def evenly(measurement: Measurement, widest: float = WIDEST) -> Even:
    """A measurement at even distances.

    An uneven axis is evened by a spline of the fifth degree; InputError for one with gaps, which are steps of more than
    ``widest`` of the usual ones.
    """
    at, step = measurement.at, measurement.step
    signals = np.stack([*measurement.signals.values()], axis=-1)
    if line := measurement.even_line():
        return Even(*line, signals)
    widths = np.diff(at)
    typical = float(np.median(widths))
    place = int(widths.argmax())
    if widths[place] > widest * typical:
        raise InputError(
            f"{measurement.source} has a gap of {widths[place]:g} after {at[place]:g}, "
            f"{widths[place] / typical:.1f} steps wide: give up to {widest:g} steps, or one file for each part"
        )
    spline = scipy.interpolate.make_interp_spline(at, signals, k=5)
    return Even(float(at[0]), step, spline(at[0] + step * np.arange(len(at))))
