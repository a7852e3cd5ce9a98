"""Green's functions from receptances (Eqs 1, 2 and 13), and their time-integrated samples (Eqs 3 and 15)."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import Complex, Real


def frequency_grid(max_frequency: float, duration: float, dt: float) -> tuple[Real, int]:
    """Frequencies (F,) in Hz up to ``max_frequency``, and the number of samples of one period.

    The period is ``duration`` s, rounded to a whole number of samples of ``dt`` s; its inverse is the spacing.
    """
    samples = round(duration / dt)
    count = min(int(max_frequency * samples * dt), samples // 2) + 1
    return np.arange(count) / (samples * dt), samples


def green_function(receptance: Complex, samples: int, dt: float) -> Real:
    """Green's function over one period, (..., samples), per s, of a receptance (..., F) on ``frequency_grid``.

    Eq. (1): ``G = F^-1(R)``, the receptance padded with zeros up to half the sampling frequency (Section 5.2). The
    second half of the period is the time before 0: the band limit rings there too.
    """
    green: Real = np.fft.irfft(receptance, samples, axis=-1) / dt
    return green


def folded(green: Real) -> Real:
    """What a band limit puts before t = 0 folded onto t > 0, the causal cosine transform; (..., samples) as given."""
    earlier = np.roll(green[..., ::-1], 1, axis=-1)  # sample n is that of time -n dt
    return np.asarray(green + earlier)


def integrated(green: Real, dt: float) -> Real:
    """Time-integrated Green's function of Eqs (3) and (15): ``dt G``, half of it for the first and the last sample."""
    weights = np.full(green.shape[-1], dt)
    weights[[0, -1]] *= 0.5
    return np.asarray(green * weights)
