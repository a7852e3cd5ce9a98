"""Receptances and Green's functions of wheelsets and tracks as arrays (Eqs 1 and 2, Figs 3 and 7)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..runtime.arrays import Complex, Real
from ..track.bloch import MAX_FREQUENCY
from ..track.bloch import receptance as bloch_receptance
from ..track.track import Track
from ..wheelset.kinds import AnyWheelset, reduce_wheelset
from .green_functions import frequency_grid
from .green_functions import green_function as transformed


def receptance(
    model: AnyWheelset | Track, frequencies: ArrayLike, *, load_at: float = 0.0, response_at: float | None = None
) -> Complex:
    """Receptance at the contacts: displacement over force, by frequency.

    Parameters
    ----------
    model
        A wheelset, whose reduced model is built or taken from the cache, or a track.
    frequencies : (F,) array
        Frequencies, Hz, from 0 up to 10 kHz for a track.
    load_at, response_at
        Of a track: where the force acts and where the rails respond, m along the track, with a sleeper at 0. The
        response is at the force if ``response_at`` is None.

    Returns
    -------
    (F, 2, 2) complex array
        ``H[f, i, j]``, m/N: displacement at contact i (wheel or rail 1 and 2) over a force at contact j. Displacements
        are positive away from the other body, time factor ``exp(+i omega t)``.

    Raises
    ------
    InputError
        For frequencies out of range.

    Examples
    --------
    >>> H = receptance(load_track("ballasted_60e1"), [0.0, 75.0, 1073.0])
    >>> H.shape, f"{H[0, 0, 0].real:.3e} m/N"
    ((3, 2, 2), '1.112e-08 m/N')
    """
    f = np.atleast_1d(np.asarray(frequencies, np.float64))
    if not (np.isfinite(f).all() and (f >= 0.0).all()):
        raise InputError(f"frequencies = {f.min():g} Hz is out of range: give 0 Hz or more")
    if not isinstance(model, Track):
        return reduce_wheelset(model).receptance(f)
    at = load_at if response_at is None else response_at
    direct, cross = (each[0] for each in bloch_receptance(model, f, load_at, at))
    return np.moveaxis(np.array([[direct, cross], [cross, direct]]), -1, 0)


def green_function(
    model: AnyWheelset | Track,
    duration: float,
    dt: float,
    *,
    max_frequency: float = 2500.0,
    load_at: float = 0.0,
    response_at: float | None = None,
) -> tuple[Real, Real]:
    """Green's function at the contacts: displacement after a unit impulse, Eqs (1) and (2) at a place that stays.

    The receptance up to ``max_frequency`` is padded with zeros and transformed back, as in the paper (Section 5.2). So
    the function rings around t = 0 where the model responds beyond that frequency. ``moving_green_functions`` has
    the functions for a load that moves along the rail.

    Parameters
    ----------
    model
        A wheelset or a track.
    duration, dt
        Length of the function and time from sample to sample, s. The transform has twice that period: let the model
        come to rest within it.
    max_frequency
        Band limit of the receptance, Hz, up to half the sampling frequency.
    load_at, response_at
        As of ``receptance``.

    Returns
    -------
    times : (N,) array
        s, from 0 to ``duration``.
    green : (2, 2, N) array
        ``G[i, j]``, m/(N s): displacement at contact i after a unit impulse at contact j.

    Raises
    ------
    InputError
        For a band limit, duration or time step out of range.

    Examples
    --------
    >>> times, G = green_function(load_wheelset("x40"), duration=1.0, dt=3.6e-5)
    >>> G.shape == (2, 2, len(times))
    True
    """
    limit = min(0.5 / dt if dt > 0.0 else 0.0, MAX_FREQUENCY)
    if not (0.0 < max_frequency <= limit):
        raise InputError(f"max_frequency = {max_frequency:g} Hz is out of range: give up to {limit:g} Hz for this dt")
    if not 2 * dt <= duration <= 1e6 * dt:
        raise InputError(f"duration = {duration:g} s is out of range: give 2 to 1e6 times dt = {dt:g} s")
    frequencies, samples = frequency_grid(max_frequency, 2 * duration, dt)
    H = receptance(model, frequencies, load_at=load_at, response_at=response_at)
    green = transformed(np.moveaxis(H, 0, -1), samples, dt)
    count = samples // 2 + 1
    times: Real = np.arange(count, dtype=np.float64) * dt
    return times, green[..., :count]
