"""When an irregularity of a tread is in the contact patch, and when a change of it can come into force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..contact.law_kernels import ContactLaw


def touched(before: ContactLaw, after: ContactLaw) -> NDArray[np.bool_]:
    """Tread positions (n,) with an irregularity of either law in the potential contact area of either wheel."""
    rough = np.asarray(before.tread.any(axis=(0, 2)) | after.tread.any(axis=(0, 2)))
    reach = max(len(before.x), len(after.x)) // 2
    wide = np.zeros(len(rough), dtype=np.bool_)
    for offset in range(-reach, reach + 1):
        wide |= np.roll(rough, offset)
    return wide


def first_clear_step(before: ContactLaw, after: ContactLaw, earliest: int, tread_origin: int) -> int:
    """First step from ``earliest`` on at which ``after`` can take the place of ``before``: no irregularity in a patch.

    If that never happens in a turn of the wheel, the change cannot wait for it and ``earliest`` is the answer.
    """
    if after is before:
        return earliest
    blocked = touched(before, after)
    turn = np.arange(earliest, earliest + len(blocked))
    clear = np.flatnonzero(~blocked[(turn - tread_origin) % len(blocked)])
    return int(turn[clear[0]]) if len(clear) else earliest
