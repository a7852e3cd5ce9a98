"""A whole run in memory, as arrays over its steps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..simulation.block import SampleBlock
from ..simulation.summary import Summary, combine, summarise
from ..stress.principal import maximum_principal
from .bag_reader import Bag
from .messages import State
from .run_info import RunInfo


@dataclass(frozen=True, eq=False)
class Recording:
    """A run; every array has one entry a step."""

    path: Path
    info: RunInfo
    states: tuple[State, ...]
    """What was simulated: the state at the start, and one for every revision."""
    start_ns: int
    """Time stamp of step 0, ns since the epoch."""
    steps: NDArray[np.uint64]
    time: NDArray[np.float64]
    """Simulated time since step 0, s."""
    position: NDArray[np.float64]
    """Along the track, m."""
    speed: NDArray[np.float64]
    """m/s"""
    step_period: NDArray[np.float64]
    """s"""
    revision: NDArray[np.uint32]
    forces: NDArray[np.float64]
    """Of wheel 1 and wheel 2, (samples, 2), N, positive in compression."""
    stresses: NDArray[np.float64]
    """(samples, nodes, 6), Pa, components as in ``COMPONENTS``."""
    nodes: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.steps)

    @cached_property
    def max_principal(self) -> NDArray[np.float64]:
        """Maximum principal stress, (samples, nodes), Pa."""
        return maximum_principal(self.stresses)

    @cached_property
    def summary(self) -> Summary:
        """Forces and stresses of the whole run in scalars."""
        return self.summary_of(slice(0, len(self)))

    def summary_of(self, part: slice) -> Summary:
        """Forces and stresses of some consecutive samples in scalars."""
        start, stop, _ = part.indices(len(self))
        cuts = start + 1 + np.flatnonzero(np.diff(self.step_period[start:stop]))
        parts = [slice(int(first), int(end)) for first, end in pairwise([start, *cuts, stop])]
        return combine(summarise(self._block(part)) for part in parts)

    def _block(self, part: slice) -> SampleBlock:
        """Samples at one speed as a block."""
        return SampleBlock(
            first_step=int(self.steps[part][0]),
            time=float(self.time[part][0]),
            step_period=float(self.step_period[part][0]),
            speed=float(self.speed[part][0]),
            position=float(self.position[part][0]),
            revision=int(self.revision[part][0]),
            forces=self.forces[part],
            stresses=self.stresses[part],
            nodes=self.nodes,
        )


def read(path: str | Path) -> Recording:
    """Read a whole bag, a file or a folder, into memory.

    Raises RecordingError in one line if it is missing, damaged, has gaps or holds no run.
    """
    bag = Bag(Path(path))
    found: list[SampleBlock] = []
    states: list[State] = []
    for event in bag.events():
        if isinstance(event, SampleBlock):
            found.append(event)
        else:
            states.append(event)
    counts = [len(block) for block in found]
    within = np.concatenate([np.arange(count) for count in counts])

    def each(name: str, dtype: Any = np.float64) -> NDArray[Any]:
        return np.repeat(np.array([getattr(block, name) for block in found], dtype=dtype), counts)

    speed, step_period = each("speed"), each("step_period")
    return Recording(
        path=bag.path,
        info=bag.info,
        states=tuple(states),
        start_ns=bag.start_ns,
        steps=each("first_step", np.uint64) + within.astype(np.uint64),
        time=each("time") + within * step_period,
        position=each("position") + within * (speed * step_period),
        speed=speed,
        step_period=step_period,
        revision=each("revision", np.uint32),
        forces=np.concatenate([block.forces for block in found]),
        stresses=np.concatenate([block.stresses for block in found]),
        nodes=found[0].nodes,
    )


def blocks(path: str | Path) -> Iterator[SampleBlock]:
    """Blocks of a bag in their order, without gaps; raises RecordingError as ``read`` does."""
    return Bag(Path(path)).blocks()
