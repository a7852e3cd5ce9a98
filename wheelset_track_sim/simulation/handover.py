"""What the approach of wheel and rail is raised by where a contact law takes the place of another with other heights.

A rough tread never leaves the contact patch, so a change of it comes into force while it is there: at once, a few
micrometres would be kilonewtons. So the approach is raised by as much as leaves each force as it is, and that fades
away like a change of the load (``loading``): in a second, as slowly as the wheelset follows without a force.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contact.law import TABLE_FORCE, approach_for_force
from ..contact.law_kernels import ContactLaw, total_separation
from ..errors import ContactError


def handover(
    before: ContactLaw, after: ContactLaw, step: int, tread_origin: int, forces: NDArray[np.float64]
) -> NDArray[np.float64]:
    """By what ``after`` needs more approach than ``before`` to bear ``forces`` (2,) N at ``step``, (2,) m."""
    return np.array(
        [
            _approach(after, wheel, step - tread_origin, step, force)
            - _approach(before, wheel, step - tread_origin, step, force)
            for wheel, force in enumerate(np.minimum(forces, TABLE_FORCE))
        ]
    )


def _approach(law: ContactLaw, wheel: int, tread_index: int, rail_index: int, force: float) -> float:
    try:
        return approach_for_force(law, wheel, tread_index, rail_index, force)
    except ContactError:  # as good a measure, and there always is one
        return float(total_separation(law, wheel, tread_index, rail_index).min())
