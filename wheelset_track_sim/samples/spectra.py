"""Spectra of signals: power spectral density, one-third-octave bands, and levels in dB.

Density. Welch's method: segments that overlap by half under a Hann window, the mean of their periodograms, one-sided::

    S(f) = 2 / (f_s sum w^2) mean |sum_n w_n (x_n - mean) exp(-2 pi i f n / f_s)|^2        unit^2 / Hz

Its integral over all frequencies is the variance of the signal, as far as the window weights all samples alike.

Bands. One third of an octave to the base 10: mid-band frequencies 1000 * 10^(k / 10) Hz, edges a factor 10^(1/20) below
and above. The mean square of a band is the integral of the density between its edges; a bin on an edge counts with its
share. A band needs ``LEAST_BINS`` of the density's bins and lies below half the sampling rate.

Levels are 20 log10(rms / reference). Over a length instead of a time, frequencies are wavenumbers, 1/m, and a band is
named by its wavelength.

Sources: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; band edges of IEC 61260-1:2014, 5.2 to 5.5;
references of ISO 1683:2015 for acceleration, velocity, displacement and force; 1 um for roughness as in EN 15610.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from ..errors import InputError
from ..runtime.arrays import Real

SEGMENT = 2**14
"""Samples of a segment at most, unless a resolution is given."""
LEAST = 64
"""Fewest samples that a spectrum is made of."""
LEAST_BINS = 2.0
"""Width of a band over the distance of the density's frequencies, at least."""
REFERENCES = {"m/s^2": 1e-6, "m/s": 1e-9, "m": 1e-12, "N": 1e-6}
"""References of levels by unit; 1 for other units."""
ROUGHNESS = 1e-6
"""Reference of roughness levels, m."""


@dataclass(frozen=True, eq=False)
class Density:
    """One-sided power spectral density."""

    frequency: Real
    """(F,) Hz, from 0 to half the sampling rate; 1/m over a length."""
    density: Real
    """(F,) square of the signal's unit per Hz, or per 1/m."""
    segments: int

    @property
    def step(self) -> float:
        """Distance of the frequencies."""
        return float(self.frequency[1])

    @property
    def mean_square(self) -> float:
        """Its integral: the variance of the signal."""
        return float(self.density.sum() * self.step)


class Bands(NamedTuple):
    """One-third-octave bands."""

    middle: Real
    """(B,) Hz, or 1/m."""
    mean_square: Real
    """(B,) square of the signal's unit."""

    def levels(self, reference: float) -> Real:
        """Levels (B,), dB re ``reference``; -inf where there is nothing."""
        with np.errstate(divide="ignore"):
            return np.asarray(10.0 * np.log10(self.mean_square / reference**2))


def density(signal: Real, rate: float, resolution: float | None = None) -> Density:
    """Power spectral density of a signal (n,) with ``rate`` samples a second, or a metre.

    Parameters
    ----------
    signal
        (n,) samples, evenly spaced.
    rate
        Hz, or 1/m.
    resolution
        Distance of the frequencies at most; None is that of segments of ``SEGMENT`` samples, or of the whole signal.

    Raises
    ------
    InputError
        For a signal that is too short.

    Examples
    --------
    >>> noise = np.random.default_rng(1).standard_normal(200_000)
    >>> f"{density(noise, 10e3).mean_square:.2f}"
    '1.00'
    """
    length = SEGMENT if resolution is None else math.ceil(rate / resolution - 1e-9)
    if resolution is None:
        length = min(length, len(signal))
    if len(signal) < max(length, LEAST):
        least = max(length, LEAST) / rate
        raise InputError(
            f"the signal has {len(signal)} samples ({len(signal) / rate:.4g} s): give {least:.4g} s or more, or a "
            "coarser resolution"
        )
    frequency, found = scipy.signal.welch(signal, rate, "hann", length, detrend="constant")
    return Density(
        np.asarray(frequency), np.asarray(found), max(1, (len(signal) - length // 2) // (length - length // 2))
    )


def third_octaves(found: Density) -> Bands:
    """Mean squares of the one-third-octave bands that a density resolves."""
    step, half = found.step, float(found.frequency[-1])
    first = math.ceil(10 * math.log10(LEAST_BINS * step / (10**0.05 - 10**-0.05) / 1000.0))
    last = math.floor(10 * math.log10(half / 10**0.05 / 1000.0) + 1e-9)
    middle = 1000.0 * 10 ** (np.arange(first, last + 1) / 10)
    bins = np.append(found.frequency - step / 2, half + step / 2)
    below = np.concatenate([[0.0], np.cumsum(found.density * step)])  # mean square below the border of each bin
    low, high = (np.interp(middle * 10**side, bins, below) for side in (-0.05, 0.05))
    return Bands(middle, high - low)


def reference_of(unit: str) -> float:
    """Reference of levels of signals in a unit."""
    return REFERENCES.get(unit, 1.0)


def roughness_levels(heights: Real, dx: float) -> tuple[Real, Real]:
    """Roughness levels in one-third-octave bands of the wavelength.

    Parameters
    ----------
    heights
        (n,) m, every ``dx`` m along the running surface.
    dx
        m.

    Returns
    -------
    wavelength, level : (B,) arrays
        m, the longest first, and dB re 1 um.
    """
    found = third_octaves(density(heights, 1.0 / dx))
    return 1.0 / found.middle, found.levels(ROUGHNESS)
