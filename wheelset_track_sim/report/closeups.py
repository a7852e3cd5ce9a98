"""Stretches of a run around its largest forces, sample by sample, kept while it passes by."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from .samples import SampleSeries, joined

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
    """Keeps ``number`` stretches from ``before`` to ``after`` samples around the largest of the peaks it is told.

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
