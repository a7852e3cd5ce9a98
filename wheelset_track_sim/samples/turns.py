"""Peaks of each turn of the wheels: what a detector beside the track would see of the wheel's whole circumference."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .block import SampleBlock
from .summary import Summary


@dataclass(frozen=True)
class TurnPeaks:
    """Largest values of the last complete turn."""

    turns: int
    """Complete turns since step 0."""
    forces: tuple[float, float]
    """Largest contact force of wheel 1 and wheel 2, N; NaN before the first turn is complete."""
    principal: tuple[float, ...]
    """Largest maximum principal stress of each node, Pa; empty likewise."""


NO_TURN = TurnPeaks(0, (math.nan, math.nan), ())
"""Before the first turn is complete."""


class TurnWatch:
    """Peaks by turns in a stream of gap-free blocks at full rate: the same ones however the stream is cut.

    Turn ``k`` has the steps from ``k`` to before ``k + 1`` times the steps in a turn; a stream that begins within a
    turn has its first complete one behind it.
    """

    def __init__(self, steps_per_revolution: int) -> None:
        """For wheels of ``steps_per_revolution`` steps."""
        self._turn = steps_per_revolution
        self._begun: list[float] | None = None
        self.last = NO_TURN
        """The last complete turn."""

    def push(self, block: SampleBlock, summary: Summary | None = None) -> list[TurnPeaks]:
        """Turns that a block completes; ``summary`` is its own if that is known already.

        Raises ValueError for a decimated block.
        """
        if block.decimation != 1:
            raise ValueError(f"peaks can be found in all steps only, not in every {block.decimation}th")
        found: list[TurnPeaks] = []
        row = 0
        while row < len(block):
            step = block.first_step + row
            left = self._turn - step % self._turn
            if left == self._turn:
                self._begun = [-math.inf] * (2 + len(block.nodes))
            if self._begun is not None:
                whole = row == 0 and left >= len(block)
                peaks = _peaks_of(summary) if summary and whole else _peaks(block, slice(row, row + left))
                self._begun = [max(pair) for pair in zip(self._begun, peaks, strict=True)]
                if row + left <= len(block):
                    wheel_1, wheel_2, *nodes = self._begun
                    self.last = TurnPeaks(step // self._turn + 1, (wheel_1, wheel_2), tuple(nodes))
                    found.append(self.last)
            row += left
        return found


def _peaks(block: SampleBlock, part: slice) -> list[float]:
    """Largest forces and stresses of a part of a block."""
    return [float(signal[part].max()) for signal in (*block.forces.T, *block.max_principal.T)]


def _peaks_of(summary: Summary) -> list[float]:
    return [load.max_force for load in summary.wheels] + [node.max_principal for node in summary.nodes]
