"""Run a simulator in a thread of its own, and deliver every chunk when it is due."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from ..samples.block import SampleBlock
from .pacing import Clock, Pace, Pacer, SteadyClock


class BlockSource(Protocol):
    """A simulator as a stream uses it."""

    @property
    def time(self) -> float:
        """Simulated time of the next sample since step 0, s."""
        ...

    @property
    def step_period(self) -> float:
        """Time of one step, s."""
        ...

    def advance(self, steps: int) -> SampleBlock:
        """The next ``steps`` samples, or fewer."""
        ...


@dataclass(frozen=True)
class Timing:
    """Pace of a chunk."""

    real_time_factor: float
    """Simulated over elapsed time since the chunk before, by the clock of the stream."""
    lag: float
    """Delay of the chunk, s of that clock."""


class Stream:
    """One stretch of a run from ``start`` to ``stop`` or to its end; no sample is lost or delivered twice.

    ``deliver`` is called in the stream's thread for every block. ``ended`` is called there once, unless ``stop`` ends
    the stream: with None at the end of the run, or with the exception that the simulator or ``deliver`` raised.
    """

    def __init__(
        self,
        source: BlockSource,
        pace: Pace,
        deliver: Callable[[SampleBlock, Timing], None],
        ended: Callable[[Exception | None], None],
        clock: Clock | None = None,
        steps: int | None = None,
    ) -> None:
        """``clock`` paces the stream; without it, or as fast as possible, it is the machine's.

        After so many ``steps`` the stream ends like a run.
        """
        self._left = steps
        self._clock = clock or SteadyClock()
        self._source, self._pace, self._deliver, self._ended = source, pace, deliver, ended
        self._stopping = False
        self._wake = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulation")

    def start(self) -> None:
        """Begin; the schedule starts now."""
        self._thread.start()

    def stop(self) -> None:
        """Deliver the current chunk at once, and return when the thread has ended; stopping again does nothing."""
        self._stopping = True
        self._wake.set()
        self._thread.join()

    def set_pace(self, pace: Pace) -> None:
        """Continue at another pace from the next chunk on, with a new schedule."""
        self._pace = pace
        self._wake.set()

    def _run(self) -> None:
        failure: Exception | None = None
        try:
            self._stream()
        except Exception as raised:  # noqa: BLE001  passed to ``ended``
            failure = raised
        if failure is not None or not self._stopping:
            self._ended(failure)

    def _stream(self) -> None:
        pace, clock, pacer = self._schedule()
        before = clock.now()
        while not self._stopping:
            steps = pace.steps(self._source.time, self._source.step_period)
            if self._left is not None:
                steps = min(steps, self._left)
            if steps == 0:
                return
            block = self._source.advance(steps)
            if self._left is not None:
                self._left -= len(block)
            spans = len(block) * block.step_period
            end = block.time + spans
            while (wait := pacer.wait(end)) > 0 and pace is self._pace and not self._stopping:
                pacer.sleep(end, self._wake)
                self._wake.clear()
            now = clock.now()
            self._deliver(block, Timing(spans / max(now - before, 1e-9), max(0.0, -wait)))
            before = now
            if pace is not self._pace:
                pace, clock, pacer = self._schedule()
                before = clock.now()

    def _schedule(self) -> tuple[Pace, Clock, Pacer]:
        """The pace that is set, its clock, and its schedule from the next sample on."""
        pace = self._pace
        clock = self._clock if pace.real_time_factor > 0 else SteadyClock()
        return pace, clock, Pacer(pace.real_time_factor, self._source.time, clock)
