"""Samples of a run as the report needs them: one row a step, both contact forces and a stress for each node."""

from __future__ import annotations

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
