"""Samples of a run as the report needs them, and stretches of them around its largest forces.

One row a step: both contact forces and a stress for each node.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..runtime.arrays import Real
from ..samples.block import SampleBlock

WHEELS = 2
"""Columns of ``SampleSeries.values`` that are contact forces; the others are stresses."""


@dataclass(frozen=True, eq=False)
class SampleSeries:
    """Consecutive samples, one for each step."""

    first_step: int
    time: Real
    """Simulated time since step 0, (samples,), s."""
    position: Real
    """Along the track, (samples,), m."""
    values: Real
    """Contact forces of wheel 1 and 2, N, then the maximum principal stress of every node, Pa: (samples, 2 + nodes)."""

    def __len__(self) -> int:
        return len(self.time)

    @property
    def end(self) -> int:
        """The step behind the last sample."""
        return self.first_step + len(self)

    @property
    def forces(self) -> Real:
        """Contact forces of both wheels, (samples, 2), N."""
        return self.values[:, :WHEELS]

    @property
    def max_principal(self) -> Real:
        """Maximum principal stress, (samples, nodes), Pa."""
        return self.values[:, WHEELS:]

    def between(self, first: int, end: int) -> SampleSeries:
        """The samples among those of steps ``first`` to ``end - 1``."""
        part = slice(max(0, first - self.first_step), max(0, end - self.first_step))
        return SampleSeries(max(first, self.first_step), self.time[part], self.position[part], self.values[part])


def samples_of(block: SampleBlock) -> SampleSeries:
    """Samples of a block."""
    within = np.arange(len(block), dtype=np.float64)
    return SampleSeries(
        first_step=block.first_step,
        time=block.time + within * block.step_period,
        position=block.position + within * (block.speed * block.step_period),
        values=np.concatenate([block.forces, block.max_principal], axis=1),
    )


def joined(parts: Sequence[SampleSeries]) -> SampleSeries:
    """Parts that follow one another as one; ValueError if there is none."""
    return SampleSeries(
        parts[0].first_step,
        np.concatenate([part.time for part in parts]),
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.values for part in parts]),
    )


NUMBER = 12
"""Close-ups of a run."""


@dataclass(frozen=True, eq=False)
class Closeup:
    """Samples around a peak."""

    step: int
    """Of the peak."""
    force: float
    """N"""
    samples: SampleSeries


class Closeups:
    """Keeps ``number`` stretches from ``before`` to ``after`` samples around the largest of the given peaks.

    A peak may be told up to ``late`` samples after it has passed.
    """

    def __init__(self, before: int, after: int, late: int, number: int = NUMBER) -> None:
        self._before, self._after, self._late, self._number = before, after, late, number
        self._recent: deque[SampleSeries] = deque()
        self._pending: list[tuple[int, float]] = []
        self._kept: list[Closeup] = []

    def push(self, samples: SampleSeries) -> None:
        """Add the samples that follow."""
        self._recent.append(samples)
        self._cut(samples.end)
        needed = min([samples.end - self._late, *(step for step, _ in self._pending)]) - self._before
        while self._recent[0].end <= needed:
            self._recent.popleft()

    def peak(self, step: int, force: float) -> None:
        """Tell a peak, N, at a step that has been pushed; one that has passed too long ago is left out."""
        if step < self._recent[0].first_step:
            return
        if len(self._kept) == self._number and force <= self._kept[-1].force:
            return
        reach = self._after // 2
        seen = [*self._pending, *((closeup.step, closeup.force) for closeup in self._kept)]
        if not any(abs(at - step) <= reach and force <= other for at, other in seen):
            self._pending.append((step, force))

    def found(self) -> list[Closeup]:
        """The close-ups so far, the largest force first."""
        if self._recent:
            self._cut(self._recent[-1].end + self._after)
        return self._kept

    def _cut(self, end: int) -> None:
        due = [peak for peak in self._pending if peak[0] + self._after <= end]
        self._pending = [peak for peak in self._pending if peak[0] + self._after > end]
        for step, force in due:
            first, last = step - self._before, step + self._after
            parts = [part.between(first, last) for part in self._recent if part.first_step < last and part.end > first]
            self._kept.append(Closeup(step, force, joined(parts)))
        if due:
            self._kept = sorted(self._kept, key=lambda closeup: -closeup.force)[: self._number]
