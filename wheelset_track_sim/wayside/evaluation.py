"""What a detector makes of a passage, and what the wheels did meanwhile.

A shear bridge reads the vertical force between its pairs of gauges: the difference of two shear forces is the resultant
of the forces in between [1]. So a detector with bridges estimates, for the wheel on each rail:

* the mean force: the mean of its bridges while the wheel is on each of them;
* the peak force: the highest value that a bridge had meanwhile, as detectors record it [2];
* the dynamic force, peak less mean, and the dynamic factor, peak over mean.

The wheel counts as on a bridge while it is between the gauges and ``SETTLED`` periods of the band away from both: the
low pass needs that to follow the wheel on and off.

1. Field validation of differential shear strain in rails, Transportation Research Record (2023),
   https://doi.org/10.1177/03611981231196151
2. Federal Railroad Administration, Safety Advisory 2023-04, Federal Register 88 (175), 62623-62624, 2023. Its dynamic
   ratio compares a loaded wagon with the empty one, and is no factor of one passage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from .detector import RAILS, Channel, Rail, ShearBridge
from .history import WaysideReading

SETTLED = 2.0
"""Periods of the band after which a bridge reads a load that has come on it, within 1 %."""


@dataclass(frozen=True)
class WheelLoads:
    """Mean and peak of a force, N; NaN if nothing reads it."""

    mean: float
    peak: float

    @property
    def dynamic_force(self) -> float:
        """Peak less mean, N."""
        return self.peak - self.mean

    @property
    def dynamic_factor(self) -> float:
        """Peak over mean."""
        return self.peak / self.mean if self.mean else math.nan


@dataclass(frozen=True)
class ChannelValues:
    """Extremes of a channel during a passage, SI units."""

    channel: Channel
    max: float
    min: float
    rms: float


@dataclass(frozen=True)
class WheelVerdict:
    """What a detector makes of the wheel on one rail, beside what that wheel did."""

    rail: Rail
    read: WheelLoads
    """By the bridges on that rail."""
    true: WheelLoads
    """Of the contact force, from the first to the last sample."""


def evaluated(reading: WaysideReading) -> tuple[WheelVerdict, WheelVerdict]:
    """Verdicts on the wheels on rail 1 and on rail 2."""
    detector, places = reading.detector, reading.places
    speed = np.gradient(places, reading.times)
    found = []
    for rail, name in enumerate(RAILS):
        values = []
        for channel, samples in zip(detector.channels, reading.values.T, strict=True):
            if isinstance(channel, ShearBridge) and channel.rail == rail:
                values.append(samples[on_bridge(channel, reading.position, places, speed, detector.band)])
        known = [each for each in values if each.size]
        read = WheelLoads(float(np.concatenate(known).mean()), float(np.concatenate(known).max())) if known else NONE
        forces = reading.forces[:, rail]
        found.append(WheelVerdict(name, read, WheelLoads(float(forces.mean()), float(forces.max()))))
    return found[0], found[1]


def on_bridge(bridge: ShearBridge, position: float, places: Real, speed: Real, band: float) -> NDArray[np.bool_]:
    """Whether a wheel at ``places`` m with ``speed`` m/s is on a bridge of a detector at ``position`` m, (samples,)."""
    on: NDArray[np.bool_] = np.abs(places - position - bridge.x) <= bridge.length / 2 - SETTLED * speed / band
    return on


def channel_values(reading: WaysideReading) -> list[ChannelValues]:
    """Extremes of all channels."""
    return [
        ChannelValues(channel, float(values.max()), float(values.min()), float(np.sqrt(np.mean(values**2))))
        for channel, values in zip(reading.detector.channels, reading.values.T, strict=True)
    ]


NONE = WheelLoads(math.nan, math.nan)
