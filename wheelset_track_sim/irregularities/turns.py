"""One turn of a wheel from samples that may hold its end twice, several turns, or the drift of a sensor."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..errors import InputError, warn
from ..runtime.arrays import Real

Turns = Literal["refuse", "first", "average"]
Drift = Literal["keep", "remove"]

UNORDERED = 0.1
"""Share of samples that lie before the sample before them, above which a file has no order."""
SEAM = 5.0
"""How many times as large as ``MOST`` of the others a step at the seam is at least that is out of line with them."""
MOST = 0.9
"""Share of steps; the rest may be in a defect."""
SMALLEST = 3e-6
"""Step at the seam below which it does not matter, m."""
ENDS = 4
"""Samples on both sides of the seam that straight lines are laid through."""
REMEDY = "give drift: remove"


def one_turn(
    along: Real, values: Real, around: float | None, turns: Turns, drift: Drift, file: str
) -> tuple[Real, Real]:
    """Samples of one turn in the order of their positions, which may begin anywhere; warns of a step at its seam.

    Parameters
    ----------
    along : (n,) array
        Positions in the order of the file.
    values : (n, columns) array
        Heights, m; NaN where there is none.
    around
        Length of a turn in the unit of ``along``; None for lengths, of which a turn may have any.
    turns
        What becomes of several turns: ``refuse``, ``first`` or ``average`` of all whole ones.
    drift
        ``remove`` takes off the straight line over the turn that makes its end meet its beginning.
    file
        Name, for messages.

    Raises
    ------
    InputError
        If there are several turns and ``turns`` is ``refuse``.
    """
    along, values, around = _unwound(along, values, around)
    step = float(np.median(np.diff(along)))
    span = float(np.ptp(along))
    around = around or span + step
    if span > around + step / 2:
        if turns == "refuse":
            raise InputError(
                f"{file} holds {(span + step) / around:.3g} turns of the wheel: give one, or turns: first or average"
            )
        along, values = _of_several(along, values, around, step, average=turns == "average")
    elif span > around - step / 2:  # the end is the beginning again
        if drift == "remove":
            values = without_drift(along, values, around)
        along, values = along[:-1], values[:-1]
        drift = "keep"
    if drift == "remove":
        values = without_drift(along, values, around)
    step_there = seam_step(along, values, around)
    if step_there:
        warn(f"{file} steps by {step_there} from the end of the turn to its beginning: {REMEDY} if the sensor drifted")
    return along, values


def _unwound(along: Real, values: Real, around: float | None) -> tuple[Real, Real, float | None]:
    """Samples by rising positions that go on from turn to turn, and the length of a turn, if it is known."""
    if (np.diff(along) < 0.0).mean() > 0.5:
        along, values = along[::-1], values[::-1]
    rise = np.diff(along)
    restarts = rise < -0.5 * (around or np.ptp(along))
    if (rise[~restarts] < 0.0).mean() <= UNORDERED and restarts.any():
        first = along[: int(np.argmax(restarts)) + 1]
        around = around or float(np.ptp(first) + np.median(np.diff(first)))
        along = along + around * np.concatenate([[0], np.cumsum(restarts)])
    order = np.argsort(along, kind="stable")
    return along[order], values[order], around


def _of_several(along: Real, values: Real, around: float, step: float, *, average: bool) -> tuple[Real, Real]:
    """The first turn, or the mean of the whole ones at its positions."""
    first = along < along[0] + around - step / 2
    if not average:
        return along[first], values[first]
    places, missing = along[first], np.isnan(values)
    total, count = np.zeros((len(places), values.shape[1])), np.zeros((len(places), values.shape[1]))
    for turn in range(int((np.ptp(along) + step) / around + 1e-6)):
        for column in range(values.shape[1]):
            known = ~missing[:, column]
            there = np.interp(places + turn * around, along, missing[:, column].astype(float)) == 0.0
            height = np.interp(places + turn * around, along[known], values[known, column])
            total[:, column] += np.where(there, height, 0.0)
            count[:, column] += there
    return places, np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)


def without_drift(along: Real, values: Real, around: float) -> Real:
    """Heights less a straight line over the turn ``around``, so that lines through both ends meet at the seam."""
    result = values.copy()
    seam = 0.5 * (along[0] + around + along[-1])
    for column in result.T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known) >= 2 * ENDS:
            begin, end = known[:ENDS], known[-ENDS:]
            before = np.polynomial.Polynomial.fit(along[end], column[end], 1)(seam)
            after = np.polynomial.Polynomial.fit(along[begin] + around, column[begin], 1)(seam)
            column -= (before - after) * (along - along[0]) / around
    return result


def seam_step(along: Real, values: Real, around: float) -> str:
    """Step from the end of a turn to its beginning that is out of line with the other steps, in words; empty if none.

    ``along`` (n,) rises over less than the turn ``around``, ``values`` are (n, columns), m.
    """
    for column in values.T:
        known = np.isfinite(column)
        place, height = along[known], column[known]
        if len(height) < 2 * ENDS or not np.median(np.diff(place)) > 0.0:
            return ""
        usual = float(np.quantile(np.abs(np.diff(height)), MOST))
        gap = max(1.0, (place[0] + around - place[-1]) / float(np.median(np.diff(place))))
        jump = abs(float(height[0] - height[-1]))
        if jump > max(SEAM * usual * gap, SMALLEST):
            return f"{1e6 * jump:.3g} um (nine of ten other steps are below {1e6 * usual:.3g} um)"
    return ""
