"""Moving Green's functions of the track, Eqs (2) and (3): the rail's response where the load has got to.

A load that hits the rail at ``x0`` is followed along the rail: sample ``n`` is the response at ``x0 + n dx`` a time
``n dt`` later. The receptance between ``x0`` and a point in bay ``b`` is a sum over the unknowns at both ends of that
bay, ``R = sum_k S_k(x, f) N_k(b, f)`` (``track.bloch``), and the inverse Fourier transform of Eq. (2) is wanted at
one instant only, so it is written out as the sum over frequencies that it is::

    G(n dt) = 2 df Re sum_f w_f R(f) exp(i omega n dt),     w = 1/2 at f = 0, else 1.

Everything that depends on the place in the bay stands in one matrix, so that a table is one matrix product.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from ..runtime.arrays import Real
from ..runtime.cache import cached
from ..runtime.progress import Progress, unreported
from ..track.bloch import bloch_track
from ..track.timoshenko import deflection_row, transfer_matrix
from ..track.track import HALVES, Half, Track
from .green_functions import integrated

if TYPE_CHECKING:
    from typing_extensions import Self


BAYS = 40
"""Bays over which a load is followed: 0.86 s at 100 km/h (Fig. 8)."""

STARTS = 24
"""Start positions in a bay at which the functions are worked out; the steps between come from a spline over the bay."""

PERIOD_SLACK = 1.15
"""Period of the inverse transform over the length of the functions; the rail has come to rest by then."""


@dataclass(frozen=True, eq=False)
class MovingGreenFunctions:
    """Moving Green's functions of one track at one speed, on the loaded rail and on the opposite one."""

    direct: Real
    """(starts, samples) of Eq. (2), per s: the load starts at ``spacing * start / starts``."""
    cross: Real
    """(starts, samples) on the opposite rail."""

    def discrete(self, steps: int, dt: float) -> tuple[Real, Real]:
        """Eq. (3) for starts at each of the ``steps`` of a bay: two tables (steps, samples) in m/N."""
        direct, cross = (integrated(self._at_steps(table, steps), dt) for table in (self.direct, self.cross))
        return direct, cross

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name."""
        return {"direct": self.direct, "cross": self.cross}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Functions from stored arrays; raises KeyError or ValueError."""
        if arrays["direct"].shape != arrays["cross"].shape or arrays["direct"].ndim != 2:
            raise ValueError("these are no moving Green's functions")
        return cls(arrays["direct"], arrays["cross"])

    @staticmethod
    def _at_steps(table: Real, steps: int) -> Real:
        starts = np.linspace(0.0, 1.0, len(table) + 1)
        # Not periodic, for there is a kink at the sleeper.
        spline = scipy.interpolate.CubicSpline(starts, np.concatenate([table, table[:1]]))
        values: Real = spline(np.arange(steps) / steps)
        return values


def moving_green_functions(
    track: Track,
    speed: float,
    dx: float,
    *,
    max_frequency: float = 2500.0,
    fold: bool = False,
    bays: int = BAYS,
    starts: int = STARTS,
    progress: Progress | None = None,
) -> MovingGreenFunctions:
    """Green's functions of the rails for a load that moves along, Eqs (2) and (3), Fig. 8; from the cache if there.

    Parameters
    ----------
    track
        The track.
    speed
        Speed of the load, m/s.
    dx
        Step along the rail, m, a whole part of the sleeper spacing.
    max_frequency
        Band limit of the receptances, Hz.
    fold
        Whether what the band limit puts before t = 0 is added at t > 0.
    bays, starts
        Sleeper bays that the load is followed over, and its start positions in a bay.
    progress
        Called with stage and fraction.

    Returns
    -------
    MovingGreenFunctions
        ``direct`` and ``cross``, (starts, samples), m/(N s): response of the loaded and of the opposite rail under the
        moving load.

    Examples
    --------
    >>> functions = moving_green_functions(load_track("ballasted_60e1"), 27.7777778, 1e-3, bays=10, starts=4)
    >>> functions.direct.shape  # 10 bays of 600 steps
    (4, 6000)
    """
    inputs = track, speed, dx, max_frequency, fold, bays, starts
    return cached("moving-green", MovingGreenFunctions, _functions, *inputs, progress=progress)


def _functions(
    track: Track,
    speed: float,
    dx: float,
    max_frequency: float,
    fold: bool,
    bays: int,
    starts: int,
    progress: Progress | None,
) -> MovingGreenFunctions:
    report = progress or unreported
    steps = round(track.spacing / dx)
    df = speed / (PERIOD_SLACK * bays * track.spacing)
    omega = 2.0 * np.pi * df * np.arange(int(max_frequency / df) + 1)
    rail = _rail(track, np.asarray(omega), np.asarray(np.arange(steps) * dx))
    halves = [_half(track, half, rail, speed, fold, bays, starts, report) for half in HALVES]
    return MovingGreenFunctions((halves[0] + halves[1]) / 2, (halves[0] - halves[1]) / 2)


class _Rail(NamedTuple):
    """The rail of one bay at P places and F frequencies; alike for both halves of the track."""

    omega: Real  # (F,) rad/s
    along: Real  # (P,) m
    shapes: Real  # (P, 4, F) deflection from the unknowns at both ends
    shear: Real  # (P, F) deflection a distance ahead of a unit force


def _rail(track: Track, omega: Real, along: Real) -> _Rail:
    either = bloch_track(track, HALVES[0], omega / (2.0 * np.pi))
    shapes = np.stack([either.interpolation(x) for x in along])
    shear = np.stack([deflection_row(track.rail, omega, x)[:, 2] for x in along])
    return _Rail(omega, along, shapes, shear)


def _half(
    track: Track, half: Half, rail: _Rail, speed: float, fold: bool, bays: int, starts: int, report: Progress
) -> Real:
    """Functions (starts, samples) of a half track."""
    omega, along, shapes, shear = rail
    steps, samples = len(along), bays * len(along)
    waves = bloch_track(track, half, omega / (2.0 * np.pi))
    weight = np.full(len(omega), 2.0) * (omega[1] / (2.0 * np.pi))
    weight[0] /= 2.0

    # rows: places in a bay; columns: the four unknowns at the bay's ends, each at all frequencies
    phases = np.exp(1j * np.outer(along / speed, omega)) * weight
    places = (shapes * phases[:, np.newaxis]).reshape(steps, -1)

    table = np.empty((starts, samples))
    for number in range(starts):
        offset = number * steps // starts
        x0 = float(along[offset])
        shares = shapes[offset]
        ends = np.stack([waves.node(node, shares) for node in range(bays + 2)])
        unknowns = np.concatenate([ends[:-1], ends[1:]], axis=1)  # (bays + 1, 4, F)
        if fold:  # the cosine transform: R and its conjugate
            unknowns = 2.0 * unknowns.real
        arrival = (np.arange(bays + 1) * track.spacing - x0) / speed
        columns = unknowns * np.exp(1j * np.outer(arrival, omega))[:, np.newaxis]
        response = (places @ columns.reshape(bays + 1, -1).T).real
        table[number] = response.T.ravel()[offset : offset + samples]
        # in the bay of the load itself: the rail with both ends held, bent by the force (``BlochTrack``)
        jump = transfer_matrix(track.rail, omega, track.spacing - x0)[:, :2, 2]
        held = shapes[offset:, 2] * jump[:, 0] + shapes[offset:, 3] * jump[:, 1] - shear[: steps - offset]
        table[number, : steps - offset] += (held * phases[: steps - offset].real).sum(axis=1) * (2.0 if fold else 1.0)
        report(f"moving Green's functions, {half}", (number + 1) / starts)
    return table
