"""What sensors gave over a run, in bounded size."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..bags.sensor_records import ANGLE, SensorPart
from ..runtime.arrays import Real
from ..samples.spectra import Bands, Density, third_octaves
from .spectrum import Welch

SEGMENT = 2**13
"""Samples of a segment of the spectra."""
BEFORE, AFTER = 0.02, 0.08
"""Time kept before and after the largest force, s."""


@dataclass
class SensorFigures:
    """One sensor over a run."""

    topic: str
    unit: str
    samples: int
    peak: dict[str, float]
    """Largest size by channel."""
    squares: dict[str, float]
    """Sum of squares by channel."""
    time: list[Real]
    """Of the samples around the largest force, s, part by part."""
    shown: dict[str, list[Real]]
    """These samples by channel."""

    welch: Welch

    def bands(self) -> Bands | None:
        """One-third-octave bands, (bands, channels) of mean squares; None if the run is too short."""
        found = self.welch.spectrum()
        if found is None:
            return None
        densities = (Density(found.frequency, column, found.segments) for column in found.density.T)
        parts = [third_octaves(each) for each in densities]
        return Bands(parts[0].middle, np.stack([each.mean_square for each in parts], axis=1))

    def rms(self, channel: str) -> float:
        """Root of the mean square."""
        return math.sqrt(self.squares[channel] / self.samples)


def sensor_figures(parts: Iterable[SensorPart], at: float) -> list[SensorFigures]:
    """Figures of each sensor from its messages, with its samples around the time ``at``, s; in bounded memory."""
    found: dict[str, SensorFigures] = {}
    for part in parts:
        channels = [name for name in part.values if name != ANGLE]
        of = found.get(part.topic)
        if of is None:
            nothing = dict.fromkeys(channels, 0.0)
            shown: dict[str, list[Real]] = {name: [] for name in channels}
            of = SensorFigures(part.topic, part.unit, 0, nothing, {**nothing}, [], shown, Welch(SEGMENT))
            found[part.topic] = of
        time = part.time + np.arange(part.end - part.first_sample, dtype=np.float64) * part.step_period
        near = (time >= at - BEFORE) & (time <= at + AFTER)
        of.welch.push(0.0, part.step_period, np.stack([part.values[name] for name in channels], axis=1))
        of.samples += len(time)
        of.time.append(time[near])
        for name in channels:
            of.peak[name] = max(of.peak[name], float(np.abs(part.values[name]).max()))
            of.squares[name] += float(part.values[name] @ part.values[name])
            of.shown[name].append(part.values[name][near])
    return [found[topic] for topic in sorted(found)]
