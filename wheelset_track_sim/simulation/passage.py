"""When an irregularity of a tread is in the contact patch, and when a change of it can come into force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contact.law_kernels import ContactLaw


def touched(before: ContactLaw, after: ContactLaw) -> NDArray[np.bool_]:
    """Tread positions (n,) at which the two laws differ for some wheel within the potential contact area."""
    changed = np.any(before.tread != after.tread, axis=(0, 2))
    reach = before.separation.shape[0] // 2
    wide = np.zeros_like(changed)
    for offset in range(-reach, reach + 1):
        wide |= np.roll(changed, offset)
    return wide


def first_clear_step(before: ContactLaw, after: ContactLaw, earliest: int, tread_origin: int) -> int:
    """First step from ``earliest`` on at which nothing that changes is in a contact patch.

    If that never happens in a turn of the wheel, the change cannot wait for it and ``earliest`` is the answer.
    """
    blocked = touched(before, after)
    turn = np.arange(earliest, earliest + len(blocked))
    clear = np.flatnonzero(~blocked[(turn - tread_origin) % len(blocked)])
    return int(turn[clear[0]]) if len(clear) else earliest
