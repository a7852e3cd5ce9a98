"""When what changes of treads and rails is in a contact patch, and when a change can come into force."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ..contact.law_kernels import ContactLaw
from ..runtime.arrays import Real

PATCH = 8
"""Steps to either side of the contact point over which heights are compared where something always differs."""


class Passage(NamedTuple):
    """Where a contact law can take the place of another."""

    step: int
    clear: bool
    """Whether nothing that differs is in a patch there."""


def differences(before: ContactLaw, after: ContactLaw, first: int, count: int, tread_origin: int) -> Real:
    """Heights by which ``after`` is above ``before`` at the contact point of ``count`` steps, (2, count, ny), m.

    Lateral positions are those of the narrower law, which hold the contacts on its surfaces.
    """
    ny = min(before.y.shape[1], after.y.shape[1])
    steps = np.arange(first, first + count)
    rise = np.zeros((2, count, ny))
    for law, sign in ((after, 1.0), (before, -1.0)):
        shown = slice((law.y.shape[1] - ny) // 2, (law.y.shape[1] + ny) // 2)
        for wheel in range(2):
            row = law.rail_row[wheel, steps % law.rail_row.shape[1]]
            rise[wheel] += sign * law.tread[wheel, (steps - tread_origin) % law.tread.shape[1], shown]
            rise[wheel] += sign * law.rail[row, shown]
    return rise


def passage(before: ContactLaw, after: ContactLaw, earliest: int, tread_origin: int) -> Passage:
    """First step from ``earliest`` on with nothing in a patch by which the two laws differ.

    If there is none in a turn of the wheel, the change cannot wait for it: then the step in that turn at which the
    heights, as means over a patch, differ least, of both wheels the one where they differ more.
    """
    if after is before:
        return Passage(earliest, clear=True)
    turn, reach = after.tread.shape[1], max(len(before.x), len(after.x)) // 2
    rise = differences(before, after, earliest - reach, turn + 2 * reach, tread_origin)
    blocked = maximum_filter1d((np.abs(rise) > 1e-15).any(axis=(0, 2)), 2 * reach + 1)[reach : reach + turn]
    clear = np.flatnonzero(~blocked)
    if len(clear):
        return Passage(earliest + int(clear[0]), clear=True)
    middle = rise.shape[2] // 2
    mean = uniform_filter1d(
        rise[:, :, middle - PATCH // 2 : middle + PATCH // 2 + 1].mean(axis=2), 2 * PATCH + 1, axis=1
    )
    apart = np.abs(mean[:, reach : reach + turn]).max(axis=0)
    return Passage(earliest + int(np.argmin(apart)), clear=False)
