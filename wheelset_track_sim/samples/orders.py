"""Signals over the angle of the wheel: orders, and the mean over turns.

A wheel turns by the same angle on every metre, whatever the speed. So a signal is sampled anew at equal steps of the
position (``resampling.band_limited``), a whole number of them a turn. There the orders, waves around the wheel, fall on
the frequencies of a transform over whole turns without a window, and turns can be averaged sample by sample: what
belongs to the wheel stays, and what does not (sleepers, rails, noise) becomes smaller with the root of their number.

Source: K. R. Fyfe and E. D. S. Munck, "Analysis of computed order tracking", Mech. Syst. Signal Process. 11 (1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..runtime.arrays import Real
from .resampling import band_limited

PER_TURN = 2048
"""Samples of a turn: one each 1.3 mm."""


@dataclass(frozen=True, eq=False)
class OverAngle:
    """A signal over whole turns of the wheel."""

    turns: Real
    """(turns, samples a turn)."""
    first: int
    """Number of the first turn; turn 0 begins where angle 0 of the treads first meets the rail."""

    @property
    def angles(self) -> Real:
        """(samples a turn,) angle of the tread at the rail, rad."""
        return np.asarray(2 * np.pi * np.arange(self.turns.shape[1]) / self.turns.shape[1])


class Orders(NamedTuple):
    """Spectrum over waves a turn."""

    order: Real
    """(O,) waves around the wheel, from 0."""
    mean_square: Real
    """(O,) square of the signal's unit."""


class Average(NamedTuple):
    """Mean over turns."""

    mean: Real
    """(samples a turn,) at ``OverAngle.angles``."""
    rest: Real
    """(samples a turn,) standard deviation of the turns about it."""
    turns: int


def over_angle(
    signal: Real, position: Real, circumference: float, origin: float = 0.0, per_turn: int = PER_TURN
) -> OverAngle:
    """Sample a signal at equal steps of the wheel's angle.

    Parameters
    ----------
    signal, position
        (n,) samples, and where on the track they are, m; positions increase.
    circumference
        Of the wheel, m.
    origin
        Position at which angle 0 meets the rail, m.
    per_turn
        Samples a turn.

    Raises
    ------
    InputError
        For a signal without a whole turn.
    """
    first = int(np.ceil((position[0] - origin) / circumference - 1e-9))
    turns = int(np.floor((position[-1] - origin) / circumference + 1e-9)) - first
    if turns < 1:
        raise InputError(
            f"the signal covers {position[-1] - position[0]:.4g} m, without a whole turn of the wheel of "
            f"{circumference:.4g} m: give a longer one"
        )
    step = circumference / per_turn
    wanted = origin + first * circumference + step * np.arange(turns * per_turn)
    places = np.interp(wanted, position, np.arange(len(position), dtype=np.float64))
    band = max(1.0, float(np.diff(places).max()))
    found = band_limited(np.ascontiguousarray(signal[:, np.newaxis]), places, band)[:, 0]
    return OverAngle(found.reshape(turns, per_turn), first)


def orders(of: OverAngle) -> Orders:
    """Mean squares of the waves around the wheel, the mean over turns; their sum is the mean square of the signal."""
    count = of.turns.shape[1]
    amplitudes = np.abs(np.fft.rfft(of.turns, axis=1)) / count
    sides = np.full(count // 2 + 1, 2.0)
    sides[0] = 1.0
    if count % 2 == 0:
        sides[-1] = 1.0
    return Orders(np.arange(count // 2 + 1, dtype=np.float64), (sides * amplitudes**2).mean(axis=0))


def averaged(of: OverAngle) -> Average:
    """Mean over turns, and what deviates from it."""
    return Average(of.turns.mean(axis=0), of.turns.std(axis=0), len(of.turns))
