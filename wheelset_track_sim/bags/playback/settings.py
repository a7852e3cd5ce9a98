"""What is to be played, and how."""

from __future__ import annotations

from dataclasses import dataclass

from ...inputs.schema import check, quantity

LONGEST = 1e7
"""Longest time in a bag, s."""


@dataclass(frozen=True)
class Playback:
    """Part of a bag and how fast it goes; times are of the bag, from its first message on."""

    rate: float = quantity(
        "", 0.0, 1000.0, "the bag's time over the elapsed time, 0 for as fast as possible,", default=1.0
    )
    start_offset: float = quantity("s", 0.0, LONGEST, "the time in the bag at which the replay begins", default=0.0)
    duration: float = quantity(
        "s", 0.0, LONGEST, "the time in the bag after which the replay ends, 0 for all of it,", default=0.0
    )
    loop: bool = False
    """Begin again at the end."""
    start_paused: bool = False
    """Wait to be told to go on."""

    def __post_init__(self) -> None:
        check(self)
