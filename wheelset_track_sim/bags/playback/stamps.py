"""Time stamps in recorded messages: the header is the first field, so its stamp has a fixed place in the CDR.

Four bytes of encapsulation say which end of a number comes first; the stamp follows, int32 seconds and uint32
nanoseconds. OMG DDS-XTypes 1.3, Section 7.6.3.
"""

from __future__ import annotations

import struct

PLACE = 4
"""Of the first field, bytes from the start."""
LITTLE, BIG = struct.Struct("<iI"), struct.Struct(">iI")
SECOND = 10**9
EARLIEST, LATEST = -(2**31) * SECOND, 2**31 * SECOND - 1
"""Stamps that fit, ns."""


def stampable(cdr: bytes) -> bool:
    """Whether a message is long enough to begin with a header."""
    return len(cdr) >= PLACE + LITTLE.size


def stamp_of(cdr: bytes) -> int:
    """Time stamp, ns, of a message whose first field is a header or a time; ValueError if it is too short for one."""
    if not stampable(cdr):
        raise ValueError(f"{len(cdr)} bytes hold no header")
    seconds, nanoseconds = _layout(cdr).unpack_from(cdr, PLACE)
    return int(seconds) * SECOND + int(nanoseconds)


def with_stamp(cdr: bytes, stamp_ns: int) -> bytes:
    """The message with another time stamp, ns, and not one bit else changed; a stamp that does not fit is cut off."""
    stamp = _layout(cdr).pack(*divmod(min(max(stamp_ns, EARLIEST), LATEST), SECOND))
    return b"".join((cdr[:PLACE], stamp, cdr[PLACE + len(stamp) :]))


def _layout(cdr: bytes) -> struct.Struct:
    return LITTLE if cdr[1] & 1 else BIG


class Restamping:
    """Current stamps instead of recorded ones, shifted by one time for all messages of a family.

    The first message after ``restart`` is stamped with the time at which it is due, and those behind it keep their
    distance to it: stamps of chunks meet exactly, whatever topics they are on, and never go back.
    """

    def __init__(self) -> None:
        self._shifts: dict[str, int] = {}
        self._latest: dict[str, int] = {}

    def restart(self) -> None:
        """What follows is from elsewhere in the bag."""
        self._shifts.clear()

    def apply(self, family: str, cdr: bytes, due_ns: int) -> bytes:
        """The message with its current stamp; ``due_ns`` is the time at which it is due, ns."""
        stamp = stamp_of(cdr)
        latest = self._latest.get(family, EARLIEST)
        shift = self._shifts.setdefault(family, max(due_ns, latest) - stamp)
        self._latest[family] = max(latest, stamp + shift)
        return with_stamp(cdr, stamp + shift)
