"""The static load over a run: a change of it comes as smoothly as vehicles are loaded.

The load is imposed by the preload, the approach of wheel and rail without dynamics: to load a contact by one kilonewton
more, the suspension has to be compressed by half a millimetre, the contact by a micrometre. At once, that half
millimetre would be an overlap in the contact. So each change rises as half a cosine: the inertia of the wheelset, which
has to follow, then takes a quarter of a percent of the change, and its bounce on the suspension (7 Hz) does not answer.
Under a bogie frame the secondary suspension is compressed as well, by two millimetres a kilonewton, and the frame takes
up to 7 % of the change while it follows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..runtime.arrays import Real

if TYPE_CHECKING:
    from typing_extensions import Self


RISE = 1.0
"""Time from the step at which a load takes effect until it is fully applied, s."""


@dataclass(frozen=True, eq=False)
class Loading:
    """Preload of both wheels, and the changes of it that are under way; each adds to it for itself."""

    settled: Real
    """(2,) m, without the changes under way."""
    changes: tuple[tuple[float, Real], ...] = ()
    """Time at which each begins, s since step 0, and what it adds in the end, (2,) m."""

    def changed(self, time: float, preload: Real) -> Self:
        """The same with a change that begins at ``time``, s, and leads to ``preload``, (2,) m."""
        added = preload - sum((rise for _, rise in self.changes), self.settled)
        if not added.any():
            return self
        return replace(self, changes=(*self.changes, (time, added)))

    def over(self, time: float) -> Self:
        """The same without the changes that are over at ``time``, s: they are settled. It changes no bit."""
        settled, left = self.settled, self.changes
        while left and time - left[0][0] >= RISE:
            settled, left = settled + left[0][1], left[1:]
        return self if left is self.changes else type(self)(settled, left)

    def at(self, times: Real) -> Real:
        """Preload at ``times`` (n,) s: (n, 2) m."""
        preload = np.tile(self.settled, (len(times), 1))
        for begin, added in self.changes:
            share = 0.5 - 0.5 * np.cos(np.pi * np.clip((times - begin) / RISE, 0.0, 1.0))
            preload += share[:, np.newaxis] * added
        return preload
