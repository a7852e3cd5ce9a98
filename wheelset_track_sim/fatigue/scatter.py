"""Scatter of the S-N curve: damage as a band, and the probability that an axle fails within a distance.

Strength is log-normal: the limit at the survival probability P is 10^(-s z) of the median, with z the normal quantile
of P and s the standard deviation of log10 of the amplitude. ``amplitude_scatter`` T is the ratio of the amplitudes that
10 % and 90 % survive, so s = log10(T) / 2.563. If the damage of a distance is 1 for the factor x of the limit, weaker
axles fail::

    P_f = Phi(log10(x) / s - z)

Source of the definitions: DIN 50100:2016; pylife, whose results a test compares.
"""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from ..errors import InputError
from ..runtime.arrays import Real
from .curve import Curve
from .rainflow import StressSpectrum
from .rainflow_kernels import damage_of, equivalent_amplitude

NORMAL = NormalDist()
BAND = 0.975
"""Survival probability of the strong end of the band; the weak one has the rest."""
WEAKEST, STRONGEST = -6.0, 6.0
"""log10 of the factors of the limit that are searched."""
HALVINGS = 60


class ScatteredDamage:
    """Damage of counted cycles for axles whose strength scatters.

    Examples
    --------
    >>> axle = ScatteredDamage(fatigue.spectrum, channel=0, curve=curve, distance=500.0)
    >>> weak, strong = axle.band("elementary", 1e6)
    >>> axle.failure_probability("haibach", 1e9)
    """

    def __init__(self, spectrum: StressSpectrum, channel: int, curve: Curve, distance: float) -> None:
        """Take the cycles of a channel that were counted over a distance, m; raises InputError without scatter."""
        if curve.amplitude_scatter is None:
            raise InputError(f"curve {curve.name} has no amplitude_scatter: give it, with its source, in a file")
        self.curve = curve
        self.deviation = math.log10(curve.amplitude_scatter) / (2 * NORMAL.inv_cdf(0.9))
        self.quantile = NORMAL.inv_cdf(curve.survival_probability)
        span, mean, number = spectrum.cells(channel)
        sensitivity = curve.mean_stress_sensitivity
        pairs = zip(span / 2, mean, strict=True)
        self.amplitudes: Real = np.array([equivalent_amplitude(each, middle, sensitivity) for each, middle in pairs])
        self.per_metre: Real = number / distance

    def damage(self, rule: str, distance: float, factor: float = 1.0) -> float:
        """Damage over a distance, m, with the limit multiplied by a factor."""
        constants = self.curve.constants[self.curve.rules.index(rule)] * np.array([factor, 1.0, 1.0, 1.0])
        each = np.array([damage_of(amplitude, constants) for amplitude in self.amplitudes])
        return float(distance * (self.per_metre @ each))

    def band(self, rule: str, distance: float) -> tuple[float, float]:
        """Damage over a distance, m, of an axle that 2.5 % are weaker than, and of one that 2.5 % are stronger than."""
        ends = (self.quantile - NORMAL.inv_cdf(BAND), self.quantile + NORMAL.inv_cdf(BAND))
        weak, strong = (self.damage(rule, distance, 10.0 ** (self.deviation * end)) for end in ends)
        return weak, strong

    def failure_probability(self, rule: str, distance: float) -> float:
        """Share of axles whose damage reaches 1 within a distance, m."""
        low, high = WEAKEST, STRONGEST
        if self.damage(rule, distance, 10.0**low) < 1.0:
            return 0.0
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if self.damage(rule, distance, 10.0**middle) >= 1.0 else (low, middle)
        return NORMAL.cdf(low / self.deviation - self.quantile)
