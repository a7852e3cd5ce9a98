"""What the approach of wheel and rail is raised by where a contact law takes the place of another with other heights.

A rough tread never leaves the contact patch, so a change of it comes into force while it is there: at once, a few
micrometres would be kilonewtons, and another slope a blow. So the approach is raised by what leaves each force, and the
speed at which wheel and rail come nearer, as they are, and that fades away within ``FADE``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..contact.law import TABLE_FORCE
from ..contact.law_kernels import ContactLaw, total_separation
from ..contact.solutions import approach_for_force
from ..errors import ContactError
from ..runtime.arrays import Real
from .passage import PATCH

FADE = 0.1
"""Time in which what an approach was raised by fades, s: some metres, behind the quickest motion of the wheelset."""


class Handover(NamedTuple):
    """What an approach is raised by from a time on."""

    time: float
    """s since step 0."""
    by: Real
    """At that time, (2,) m."""
    rate: Real
    """Its change there, (2,) m/s."""

    def at(self, times: Real) -> Real:
        """At ``times`` (n,), s, from ``time`` on: a cubic that ends at nothing, without a kink, (n, 2) m."""
        u = np.clip((times - self.time) / FADE, 0.0, 1.0)[:, np.newaxis]
        return (1.0 - u) ** 2 * ((1.0 + 2.0 * u) * self.by + FADE * u * self.rate)


def handover(
    before: ContactLaw, after: ContactLaw, step: int, tread_origin: int, forces: Real, time: float, step_period: float
) -> Handover:
    """For ``after`` in the place of ``before`` from ``step`` on, at ``time``, s; contacts bear ``forces`` (2,) N.

    The rate is that over a patch around the step: what is shorter is no motion of the wheelset.
    """
    behind, here, ahead = (
        _needed(after, at, tread_origin, forces) - _needed(before, at, tread_origin, forces)
        for at in (step - PATCH, step, step + PATCH)
    )
    return Handover(time, here, (ahead - behind) / (2 * PATCH * step_period))


def _needed(law: ContactLaw, step: int, tread_origin: int, forces: Real) -> Real:
    """Approach at which contacts at a step bear ``forces``, (2,) m."""
    return np.array([_approach(law, wheel, step - tread_origin, step, float(forces[wheel])) for wheel in (0, 1)])


def _approach(law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float) -> float:
    try:
        return approach_for_force(law, wheel, tread_index, rail_index, min(force, TABLE_FORCE))
    except ContactError:  # as good a measure, and there always is one
        return float(total_separation(law, wheel, tread_index, rail_index).min())
