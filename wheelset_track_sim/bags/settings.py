"""How a run is recorded."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from ..inputs.schema import check, quantity, quantity_of, unknown

CONTINUOUS, SNAPSHOT = MODES = ("continuous", "snapshot")
LEAST = {"max_size": 1e6, "max_duration": 1.0, "max_total_size": 1e7}
"""Smallest bounds: a file of a bag holds several chunks at any speed."""
SHARE = 4
"""Files that a bag of bounded size has at least, so that little goes with the oldest."""


@dataclass(frozen=True)
class RecordSettings:
    """Bounds of the files of a bag, and of the messages kept in memory.

    Sizes and durations are bounds of files, and 0 is none: a file ends before a chunk that would make it longer than
    ``max_size``, and with ``max_duration``; the oldest files are removed before a chunk that would make all together
    larger than ``max_total_size``.
    """

    mode: str = CONTINUOUS
    """``continuous``: all; ``snapshot``: what is around impacts, or asked for."""
    max_size: int = quantity(
        "bytes", 0, 10**15, "the size at which another file of the bag begins, 0 for none,", default=0
    )
    max_duration: float = quantity(
        "s", 0.0, 1e6, "the simulated time after which another file of the bag begins, 0 for none,", default=0.0
    )
    max_total_size: int = quantity(
        "bytes", 0, 10**15, "the size of a bag above which its oldest files are removed, 0 for none,", default=0
    )
    snapshot_duration: float = quantity("s", 0.1, 60.0, "the time before an impact that a snapshot holds", default=10.0)
    snapshot_after: float = quantity("s", 0.0, 60.0, "the time after an impact that a snapshot holds", default=1.0)
    buffer_size: int = quantity(
        "bytes", 10**6, 10**10, "the size of the buffer that holds samples for a slow disk", default=100_000_000
    )

    def __post_init__(self) -> None:
        check(self)
        if self.mode not in MODES:
            raise InputError(unknown("mode", f"mode = {self.mode!r}", self.mode, MODES))
        for name, least in LEAST.items():
            value, unit = getattr(self, name), quantity_of(RecordSettings, name).unit
            if 0 < value < least:
                raise InputError(
                    f"{name} = {value:g} {unit} is out of range: give at least {least:g} {unit}, or 0 for no limit"
                )

    @property
    def splits(self) -> bool:
        """Whether a bag is split into files automatically."""
        return max(self.max_size, self.max_duration, self.max_total_size) > 0

    @property
    def file_size(self) -> int:
        """Size of a file, bytes: a fraction of all at most; 0 for no bound."""
        bounds = [size for size in (self.max_size, self.max_total_size // SHARE) if size]
        return min(bounds, default=0)
