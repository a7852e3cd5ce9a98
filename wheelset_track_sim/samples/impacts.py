"""Impacts of a wheel, found in the stream as a wayside detector finds them: by the force that the rail bears.

An impact begins where the contact force of a wheel rises above a threshold, and is over when the force has not been
above it for a distance (``ImpactSettings.separation``): a wheel that lands, parts again and lands again is one impact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from .block import SampleBlock
from .summary import Summary


@dataclass(frozen=True)
class ImpactSettings:
    """What makes an impact."""

    threshold: float = quantity("N", 1e3, 5e6, "the contact force above which an impact begins", default=200e3)
    """The default is twice the static load of the shipped scenarios; ``docs/howto/monitoring.md`` has limits in use."""
    separation: float = quantity(
        "m", 0.001, 2.0, "the distance without a force above the threshold that ends an impact", default=0.1
    )

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Impact:
    """One impact of one wheel."""

    wheel: int
    """0 or 1."""
    step: int
    """Of the largest force."""
    time: float
    """Of the largest force since step 0, s."""
    speed: float
    """There, m/s."""
    position: float
    """Of the largest force along the track, m."""
    revision: int
    """Number of the accepted change in force there."""
    angle: float
    """Place on the circumference of the wheel that met the rail there, rad, from 0 to below 2 pi."""
    peak_force: float
    """Largest force, N."""
    static_force: float
    """Of this wheel at rest, N."""
    duration: float
    """Time above the threshold, s."""
    contact_loss: float
    """Time without contact before the largest force: since that of the impact before, in the last turn at most, s."""
    threshold: float
    """N"""

    @property
    def dynamic_factor(self) -> float:
        """Largest force over the force at rest."""
        return self.peak_force / self.static_force


class ImpactDetector:
    """Impacts in a stream of gap-free blocks at full rate: the same ones however the stream is cut."""

    def __init__(self, steps_per_revolution: int, tread_origin: int, settings: ImpactSettings | None = None) -> None:
        """Angle 0 of wheels of ``steps_per_revolution`` steps meets the rail at step ``tread_origin``."""
        self.settings = settings or ImpactSettings()
        """In force from the next impact on."""
        self._turn, self._origin = steps_per_revolution, tread_origin
        self._open: list[_Open | None] = [None, None]
        self._losses = _Losses(), _Losses()
        self._since = [0, 0]

    def push(self, block: SampleBlock, static_force: float, summary: Summary | None = None) -> list[Impact]:
        """Impacts that are over with this block, in the order in which they ended.

        ``static_force`` is that of each wheel in this block, N; with the block's ``summary``, if that is known already,
        a quiet block costs nothing. Raises ValueError for a decimated block.
        """
        if block.decimation != 1:
            raise ValueError(f"impacts can be found in all steps only, not in every {block.decimation}th")
        if len(block) == 0:
            return []
        over: list[_Open] = []
        for wheel, (lowest, highest) in enumerate(_ranges(block, summary)):
            lost = lowest <= 0
            if not lost and self._open[wheel] is None and highest <= self.settings.threshold:
                continue
            force = np.ascontiguousarray(block.forces[:, wheel])
            if lost:
                steps = block.first_step + np.flatnonzero(force <= 0)
                self._losses[wheel].add(steps, block.step_period, block.first_step - self._turn)
            over += self._impacts(wheel, block, force, static_force)
        return _in_order(over)

    def finish(self) -> list[Impact]:
        """Impacts that are not over, as they stand at the end of a run."""
        over = [item for item in self._open if item is not None]
        self._open = [None, None]
        return _in_order(over)

    def _impacts(self, wheel: int, block: SampleBlock, force: Real, static_force: float) -> list[_Open]:
        """Those of one wheel, with its ``force``, that are over with a block."""
        first, row = block.first_step, 0
        over: list[_Open] = []
        reach = max(1, round(self.settings.separation / (block.speed * block.step_period)))
        while True:
            now = self._open[wheel]
            threshold = self.settings.threshold if now is None else now.threshold
            above = row + np.flatnonzero(force[row:] > threshold)
            if now is None:
                if not len(above):
                    return over
                now = _Open(wheel, threshold, reach, self._since[wheel], first + int(above[0]))
                self._open[wheel] = now
            if len(above) and above[-1] > now.last - first + now.reach:  # there may be a gap that ends it
                gaps = np.diff(above, prepend=now.last - first) > now.reach
                above = above[: gaps.argmax()] if gaps.any() else above
            if len(above):
                self._extend(now, block, force, above, static_force)
            if first + len(force) <= now.last + now.reach:
                return over
            over.append(now)
            self._open[wheel] = None
            row = max(0, now.last + now.reach + 1 - first)

    def _extend(
        self, now: _Open, block: SampleBlock, force: Real, above: NDArray[np.int64], static_force: float
    ) -> None:
        """Take the samples ``above`` the threshold into an impact."""
        now.last = block.first_step + int(above[-1])
        now.above[block.step_period] = now.above.get(block.step_period, 0) + len(above)
        row = int(above[force[above].argmax()])
        if now.peak is not None and force[row] <= now.peak.peak_force:
            return
        step = block.first_step + row
        since = max(now.since, step - self._turn)
        now.peak = Impact(
            wheel=now.wheel,
            step=step,
            time=block.time + row * block.step_period,
            speed=block.speed,
            position=block.position + row * (block.speed * block.step_period),
            revision=block.revision,
            angle=(step - self._origin) % self._turn * (2 * math.pi / self._turn),
            peak_force=float(force[row]),
            static_force=static_force,
            duration=math.nan,
            contact_loss=self._losses[now.wheel].time(since, step),
            threshold=now.threshold,
        )
        self._since[now.wheel] = step + 1


@dataclass
class _Open:
    """An impact that is not over."""

    wheel: int
    threshold: float
    reach: int
    """Steps without a force above the threshold that end it."""
    since: int
    """Step behind the largest force of the impact before."""
    last: int
    """Latest step above the threshold."""
    peak: Impact | None = None
    above: dict[float, int] = field(default_factory=dict)
    """Number of steps above the threshold by their duration."""

    @property
    def impact(self) -> Impact:
        """As it stands."""
        assert self.peak is not None
        return replace(self.peak, duration=sum(count * period for period, count in self.above.items()))


class _Losses:
    """Steps of a wheel without contact, as runs of steps of one duration."""

    def __init__(self) -> None:
        self._runs: list[tuple[int, int, float]] = []  # first step, step behind the last, duration of a step

    def add(self, steps: NDArray[np.int64], period: float, forget: int) -> None:
        """Take in ``steps``, and forget those before ``forget``."""
        whole = steps[-1] - steps[0] < len(steps)
        for run in [steps] if whole else np.split(steps, 1 + np.flatnonzero(np.diff(steps) > 1)):
            first, end = int(run[0]), int(run[-1]) + 1
            if self._runs and self._runs[-1][1:] == (first, period):
                first = self._runs.pop()[0]
            self._runs.append((first, end, period))
        self._runs = [run for run in self._runs if run[1] > forget]

    def time(self, start: int, stop: int) -> float:
        """Time without contact from step ``start`` to before ``stop``, s."""
        return sum(max(0, min(end, stop) - max(first, start)) * period for first, end, period in self._runs)


def _ranges(block: SampleBlock, summary: Summary | None) -> list[tuple[float, float]]:
    """Smallest and largest force of each wheel."""
    if summary is not None:
        return [(load.min_force, load.max_force) for load in summary.wheels]
    return [(float(force.min()), float(force.max())) for force in block.forces.T]


def _in_order(over: list[_Open]) -> list[Impact]:
    return [item.impact for item in sorted(over, key=lambda item: (item.last, item.wheel))]
