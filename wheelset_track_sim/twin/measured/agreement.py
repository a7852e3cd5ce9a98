"""How well a simulated signal agrees with a measured one, as a whole and impact by impact.

Magnitude and phase are separated after T. L. Geers (Shock and Vibration Bulletin 54 (1984) 99-107) in the form of
M. A. Sprague and T. L. Geers (Int. J. Numer. Meth. Eng. 60 (2004) 2467-2499), and after D. M. Russell (68th Shock and
Vibration Symposium (1997)); both as L. E. Schwer compares them (Engineering with Computers 23 (2007) 295-309). With m
measured, s simulated, and ``I_ab`` the integral of ``a b``::

    Sprague and Geers:  M = sqrt(I_ss / I_mm) - 1                        P = arccos(I_ms / sqrt(I_mm I_ss)) / pi
    Russell:            M = sign(d) log10(1 + |d|), d = (I_ss - I_mm) / sqrt(I_ss I_mm)      P the same
    together:           C = sqrt(M^2 + P^2);  Russell: sqrt(pi / 4 (M^2 + P^2))

All of them are of the dynamic parts: the static load would hide every phase error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...runtime.arrays import Real
from .alignment import correlation


@dataclass(frozen=True)
class Agreement:
    """One signal, simulated less measured; in its own unit but for ratios."""

    mean_error: float
    """Of the means."""
    rms_error: float
    """Root of the mean square of the difference, means included."""
    relative_error: float
    """``rms_error`` over the root of the mean square of what was measured."""
    max_measured: float
    max_simulated: float
    min_measured: float
    min_simulated: float
    correlation: float
    """Pearson's coefficient."""
    gain: float
    """Measured over simulated: the factor on the simulation that leaves least of the measurement."""
    magnitude_error: float
    """Sprague and Geers; positive if the simulation swings more."""
    phase_error: float
    """Sprague and Geers, and Russell; from 0 to 1, which is opposite phase."""
    comprehensive_error: float
    """Sprague and Geers."""
    russell_magnitude_error: float
    russell_comprehensive_error: float

    @property
    def peak_error(self) -> float:
        """Of the largest values."""
        return self.max_simulated - self.max_measured


def agreement(measured: Real, simulated: Real) -> Agreement:
    """Agreement of two signals (n,) on one axis; NaN where a signal that does not change leaves one undefined."""
    error = simulated - measured
    rms = float(np.sqrt(np.mean(error**2)))
    level = float(np.sqrt(np.mean(measured**2)))
    m, s = measured - measured.mean(), simulated - simulated.mean()
    mm, ss, ms = float(m @ m), float(s @ s), float(m @ s)
    defined = mm > 0 and ss > 0
    magnitude = math.sqrt(ss / mm) - 1 if defined else math.nan
    phase = math.acos(min(1.0, max(-1.0, ms / math.sqrt(mm * ss)))) / math.pi if defined else math.nan
    relative = (ss - mm) / math.sqrt(ss * mm) if defined else math.nan
    russell = math.copysign(math.log10(1 + abs(relative)), relative)
    return Agreement(
        mean_error=float(error.mean()),
        rms_error=rms,
        relative_error=rms / level if level > 0 else math.nan,
        max_measured=float(measured.max()),
        max_simulated=float(simulated.max()),
        min_measured=float(measured.min()),
        min_simulated=float(simulated.min()),
        correlation=correlation(measured, simulated),
        gain=ms / ss if defined else math.nan,
        magnitude_error=magnitude,
        phase_error=phase,
        comprehensive_error=math.hypot(magnitude, phase),
        russell_magnitude_error=russell,
        russell_comprehensive_error=math.sqrt(math.pi / 4) * math.hypot(russell, phase),
    )


class PairedImpact(NamedTuple):
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


def paired(
    name: str, at: Real, measured: Real, simulated: Real, threshold: float, separation: float
) -> list[PairedImpact]:
    """Impacts of a signal in the order of the axis; peaks nearer than ``separation`` are one impact."""
    ours, theirs = (peaks(at, signal, threshold, separation) for signal in (measured, simulated))
    found = []
    for peak in ours:
        near = [other for other in theirs if abs(at[other] - at[peak]) <= separation]
        match = min(near, key=lambda other: abs(at[other] - at[peak]), default=None)
        theirs_there = math.nan if match is None else float(simulated[match])
        found.append(PairedImpact(name, float(at[peak]), float(measured[peak]), theirs_there))
        theirs = [other for other in theirs if other != match]
    found += [PairedImpact(name, float(at[peak]), math.nan, float(simulated[peak])) for peak in theirs]
    return sorted(found, key=lambda pair: pair.at)
