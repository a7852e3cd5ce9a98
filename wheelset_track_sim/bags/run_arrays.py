"""Read a run, or a part of it, as arrays over its steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.principal import maximum_principal
from ..samples.summary import Summary, combine, summarise
from .bag import Bag
from .bag_reader import Lost
from .messages import State
from .run_info import RunInfo
from .sensor_records import SensorRecord, sensor_records
from .window import RunWindow

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset


@dataclass(frozen=True, eq=False)
class Recording:
    """A run in memory; every array has one entry a step.

    Examples
    --------
    >>> run = read_bag("ten_seconds.mcap")
    >>> run.forces.shape[0] == run.stresses.shape[0] == len(run.time) == len(run)
    True
    >>> f"{run.summary.wheels[0].max_force / 1e3:.0f} kN"
    '293 kN'
    """

    path: Path
    info: RunInfo
    states: tuple[State, ...]
    """The state at the start, and one for every revision."""
    start_ns: int
    """Time stamp of step 0, ns since the epoch."""
    steps: NDArray[np.uint64]
    time: Real
    """Simulated time since step 0, s."""
    position: Real
    """Along the track, m."""
    speed: Real
    """m/s"""
    step_period: Real
    """s"""
    revision: NDArray[np.uint32]
    forces: Real
    """Of wheel 1 and wheel 2, (samples, 2), N, positive in compression."""
    stresses: Real
    """(samples, nodes, 6), Pa, components as in ``COMPONENTS``."""
    nodes: tuple[str, ...]
    sensors: Mapping[str, SensorRecord] = field(default_factory=dict)
    """What sensors gave, by topic, such as ``axle_box_acceleration`` and ``strain/NAME``."""

    def __len__(self) -> int:
        return len(self.steps)

    @cached_property
    def max_principal(self) -> Real:
        """Maximum principal stress, (samples, nodes), Pa."""
        return maximum_principal(self.stresses)

    def to_pandas(self) -> DataFrame:
        """Everything as columns over the time; units and origin are in ``attrs``.

        Raises InputError if pandas is not installed (extra ``analysis``).
        """
        from .frames import dataframe

        return dataframe(self)

    def to_xarray(self) -> Dataset:
        """Arrays by time, wheel, node and component, which are not copied; units are in ``attrs`` of each.

        Raises InputError if xarray is not installed (extra ``analysis``).
        """
        from .frames import dataset

        return dataset(self)

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


def read_bag(
    path: str | Path,
    *,
    start: float | None = None,
    stop: float | None = None,
    steps: tuple[int, int | None] = (0, None),
    nodes: Sequence[str] | None = None,
    lost: Lost | None = None,
) -> Recording:
    """Read a bag, or a part of it, into memory.

    Parameters
    ----------
    path
        A bag: a file or a folder, recorded by this package or by ``ros2 bag record``.
    start, stop
        Simulated time, s, from which and up to which, exclusively, samples are read.
    steps
        First step, and the step up to which, exclusively, samples are read; None for the end.
    nodes
        Names of the stress nodes that are read; None for all.
    lost
        Called with every damage and gap, which is left out; ``steps`` of the recording may jump then. Without it,
        damage raises RecordingError.

    Returns
    -------
    Recording
        Arrays over the steps: forces (n, 2) N, stresses (n, nodes, 6) Pa, time, position, speed, and the states; and
        what sensors gave, at times of their own.

    Raises
    ------
    RecordingError
        In one line, if the bag is missing, damaged, has gaps, or holds no run or nothing of the part.
    InputError
        For a part that cannot be, or a node that is not in the bag.

    Examples
    --------
    >>> run = read_bag("ten_seconds.mcap", start=2.0, stop=2.5, nodes=["A1"])
    >>> run.forces.shape[1], run.nodes
    (2, ('A1',))
    """
    bag, window = Bag(Path(path), lost), _window(start, stop, steps)
    found: list[SampleBlock] = []
    states: list[State] = []
    for event in bag.events(window, nodes):
        if isinstance(event, SampleBlock):
            found.append(event)
        else:
            states.append(event)
    counts = [len(block) for block in found]
    within = np.concatenate([np.arange(count) for count in counts])

    def each(name: str, dtype: Any = np.float64) -> NDArray[Any]:
        return np.repeat(np.array([getattr(block, name) for block in found], dtype=dtype), counts)

    speed, step_period = each("speed"), each("step_period")
    time, number = each("time") + within * step_period, each("first_step", np.uint64) + within.astype(np.uint64)
    held = np.flatnonzero(window.holds(number, time))
    if not len(held):
        raise bag.nothing(window)
    part = slice(held[0], held[-1] + 1)  # of the outer blocks
    return Recording(
        path=bag.path,
        info=bag.info,
        states=tuple(states)
        if window.whole
        else _in_force(bag.each_state(), int(number[part][0]), int(number[part][-1])),
        start_ns=bag.start_ns,
        steps=number[part],
        time=time[part],
        position=(each("position") + within * (speed * step_period))[part],
        speed=speed[part],
        step_period=step_period[part],
        revision=each("revision", np.uint32)[part],
        forces=np.concatenate([block.forces for block in found])[part],
        stresses=np.concatenate([block.stresses for block in found])[part],
        nodes=found[0].nodes,
        sensors=sensor_records(bag.reader, window, float(time[part][0]), float(time[part][-1] + step_period[part][-1])),
    )


def blocks(
    path: str | Path,
    *,
    start: float | None = None,
    stop: float | None = None,
    steps: tuple[int, int | None] = (0, None),
    nodes: Sequence[str] | None = None,
    lost: Lost | None = None,
) -> Iterator[SampleBlock]:
    """Whole blocks of a bag in their order, one at a time in memory; arguments and errors as of ``read_bag``."""
    return Bag(Path(path), lost).blocks(_window(start, stop, steps), nodes)


def _window(start: float | None, stop: float | None, steps: tuple[int, int | None]) -> RunWindow:
    return RunWindow(-math.inf if start is None else start, math.inf if stop is None else stop, *steps)


def _in_force(states: Iterable[State], first: int, last: int) -> tuple[State, ...]:
    """States from the one in force at step ``first`` to step ``last``; later ones are not read."""
    found: list[State] = []
    for state in takewhile(lambda state: state.first_step <= last, states):
        found = [state] if state.first_step <= first else [*found, state]
    return tuple(found)
