"""Impacts in two signals on one axis, paired one by one."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...runtime.arrays import Real


class Pair(NamedTuple):
    """An impact as measured and as simulated; NaN for the one that did not show it."""

    signal: str
    at: float
    """Of the measured peak, on the simulation's axis, s or m; of the simulated one if there is no other."""
    measured: float
    """Peak, N."""
    simulated: float
    """Peak, N."""

    @property
    def error(self) -> float:
        """Of the simulated peak, as a share of the measured one."""
        return self.simulated / self.measured - 1.0


def peaks(at: Real, signal: Real, threshold: float, separation: float) -> list[int]:
    """Index of the largest value of each stretch above ``threshold``; two nearer than ``separation`` are one."""
    above = np.flatnonzero(signal > threshold)
    if not len(above):
        return []
    stretches = np.split(above, 1 + np.flatnonzero(np.diff(at[above]) > separation))
    return [int(stretch[signal[stretch].argmax()]) for stretch in stretches]


def paired(name: str, at: Real, measured: Real, simulated: Real, threshold: float, separation: float) -> list[Pair]:
    """Impacts of a signal in the order of the axis; peaks nearer than ``separation`` are one impact."""
    ours, theirs = (peaks(at, signal, threshold, separation) for signal in (measured, simulated))
    found = []
    for peak in ours:
        near = [other for other in theirs if abs(at[other] - at[peak]) <= separation]
        match = min(near, key=lambda other: abs(at[other] - at[peak]), default=None)
        theirs_there = math.nan if match is None else float(simulated[match])
        found.append(Pair(name, float(at[peak]), float(measured[peak]), theirs_there))
        theirs = [other for other in theirs if other != match]
    found += [Pair(name, float(at[peak]), math.nan, float(simulated[peak])) for peak in theirs]
    return sorted(found, key=lambda pair: pair.at)
