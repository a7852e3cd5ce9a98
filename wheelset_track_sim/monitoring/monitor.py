"""Reports of a run while it streams: the worst since the last report, at least of a whole turn of the wheels."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..live.run_messages import Events
from ..live.stream import Timing
from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..samples.rotating_bending import RotatingBending
from ..samples.summary import Summary
from ..samples.turns import NO_TURN
from ..scenario import WHEELS, Scenario
from ..verdict.limit_set import Level, LimitSet
from ..verdict.verdicts import Verdict, verdicts, worst
from ..wheelset.reduced import COMPONENTS
from .limits import Limits
from .status import (
    NodeFigures,
    PaceFigures,
    Status,
    WheelFigures,
    lag_level,
    pace_status,
    stress_level,
    stress_status,
    verdict_status,
    wheel_level,
    wheel_status,
)

AXIAL = COMPONENTS.index("yy")
"""Stress along the axle, which bends: its component."""
SPAN = 0.5
"""Elapsed time that a real-time factor is of at least, s: of one chunk, which may be late, it says nothing."""


@dataclass
class _Window:
    """The worst since the last report."""

    forces: list[float]
    losses: list[float]
    stresses: list[float]
    amplitudes: list[float]
    lag: float = 0.0
    empty: bool = True


@dataclass
class _Stretch:
    """Time over which the real-time factor is measured, s; reports that come early do not end it."""

    simulated: float = 0.0
    elapsed: float = 0.0


class Monitor:
    """Levels of both wheels, of all stress nodes and of the pace; ``push`` and ``report`` may be in two threads.

    A peak stays until a whole report period and a whole turn of the wheels have passed without it.
    """

    def __init__(
        self,
        nodes: Sequence[str],
        threshold: float,
        limits: Limits,
        steps_per_revolution: int,
        constant_stress: Real,
        clock: Callable[[], float] = time.monotonic,
        limit_set: LimitSet | None = None,
    ) -> None:
        """For stress ``nodes``, with what press fits and the like add there at all times, (nodes, 6), Pa.

        ``threshold`` is the force that makes an impact, N. With a ``limit_set`` there is a verdict by it, too.
        """
        self.limits, self.threshold = limits, threshold
        """May change while the run goes on."""
        self._limit_set = limit_set
        self._irregularities: tuple[Any, ...] = ()
        self._wanted = 0.0
        self._factor = math.nan  # of the last whole stretch
        self._stretch = _Stretch()
        self._nodes = tuple(nodes)
        self._means = np.ascontiguousarray(constant_stress[:, AXIAL])
        self._bending = RotatingBending(steps_per_revolution, len(self._nodes))
        self._clock = clock
        self._lock = threading.Lock()
        self._turn = NO_TURN
        self._impacts = [0, 0]
        self._static = math.nan
        self._window = self._empty()
        self._seen_at = clock()
        self._levels: list[Level] = []
        self._last: list[Status] = []

    @property
    def wanted(self) -> float:
        """Real-time factor that is wanted; 0 is as fast as possible."""
        return self._wanted

    @wanted.setter
    def wanted(self, factor: float) -> None:
        with self._lock:
            if factor != self._wanted:  # what was reached until now is no answer to that
                self._wanted, self._factor, self._stretch = factor, math.nan, _Stretch()

    def push(self, block: SampleBlock, summary: Summary, events: Events, timing: Timing, on: Scenario) -> bool:
        """Take in a block; whether something is worse now than it was last reported.

        ``on`` is the scenario in force.
        """
        with self._lock:
            window, self._turn, self._static = self._window, events.turn, on.wheel_load
            self._irregularities = on.irregularities
            for wheel, load in enumerate(summary.wheels):
                window.forces[wheel] = max(window.forces[wheel], load.max_force)
                window.losses[wheel] += load.contact_loss
            for number, node in enumerate(summary.nodes):
                window.stresses[number] = max(window.stresses[number], node.max_principal)
            turns = self._bending.push(block.first_step, block.stresses[:, :, AXIAL] - self._means)
            for amplitudes in (*turns, self._bending.amplitudes.begun):
                window.amplitudes = [max(pair) for pair in zip(window.amplitudes, amplitudes, strict=True)]
            for impact in events.impacts:
                self._impacts[impact.wheel] += 1
            window.lag, window.empty = max(window.lag, timing.lag), False
            self._stretch.simulated += len(block) * block.step_period
            self._stretch.elapsed += len(block) * block.step_period / timing.real_time_factor
            self._seen_at = self._clock()
            levels = self._levels_now()
            return not self._levels or any(now > told for now, told in zip(levels, self._levels, strict=True))

    def report(self) -> list[Status]:
        """Wheels, stress nodes and pace; begins a new period, unless there was no sample since the last report."""
        with self._lock:
            if not self._window.empty:
                self._measure()
                self._levels, self._last = self._levels_now(), self._statuses()
                self._window = self._empty()
            silence = self._clock() - self._seen_at
            if silence <= self.limits.stale_after and self._last:
                return self._last
            told = f"no sample for {silence:.0f} s" if silence > self.limits.stale_after else "no sample yet"
            return self._stale(told)

    def stale(self, why: str) -> list[Status]:
        """All stale for a reason, such as a run that is paused."""
        with self._lock:
            return self._stale(why)

    def _empty(self) -> _Window:
        nothing = [-math.inf] * len(self._nodes)
        return _Window([-math.inf] * 2, [0.0] * 2, nothing, [0.0] * len(self._nodes))

    def _amplitudes(self) -> list[float]:
        """Amplitudes of the bending stress at the nodes, Pa."""
        found: list[float] = np.fmax(self._window.amplitudes, self._bending.amplitudes.turn).tolist()
        return found

    def _peaks(self) -> tuple[list[float], list[float]]:
        """Forces of the wheels, N, and stresses at the nodes, Pa."""
        if self._turn.turns == 0:
            return self._window.forces, self._window.stresses
        forces = [max(pair) for pair in zip(self._window.forces, self._turn.forces, strict=True)]
        return forces, [max(pair) for pair in zip(self._window.stresses, self._turn.principal, strict=True)]

    def _measure(self) -> None:
        """The real-time factor, if enough time has passed since the last one."""
        if self._stretch.elapsed >= SPAN:
            self._factor, self._stretch = self._stretch.simulated / self._stretch.elapsed, _Stretch()

    def _levels_now(self) -> list[Level]:
        """Levels of forces, stresses and lag; that of the real-time factor is known when the period is over."""
        forces, _ = self._peaks()
        return [
            *(wheel_level(force, self.threshold, self.limits) for force in forces),
            *(stress_level(amplitude, self.limits) for amplitude in self._amplitudes()),
            lag_level(self._window.lag, self.limits),
            worst(self._verdicts()),
        ]

    def _verdicts(self) -> tuple[Verdict, ...]:
        if self._limit_set is None:
            return ()
        amplitudes = dict(zip(self._nodes, self._amplitudes(), strict=True))
        return verdicts(self._limit_set, self._peaks()[0], self._irregularities, amplitudes)

    def _statuses(self) -> list[Status]:
        forces, stresses = self._peaks()
        wheels = [
            wheel_status(
                name,
                WheelFigures(
                    peak_force=forces[wheel],
                    turn_peak_force=self._turn.forces[wheel],
                    static_force=self._static,
                    contact_loss=self._window.losses[wheel],
                    impacts=self._impacts[wheel],
                    threshold=self.threshold,
                ),
                self.limits,
            )
            for wheel, name in enumerate(WHEELS)
        ]
        figures = zip(self._amplitudes(), self._bending.amplitudes.turn, map(float, self._means), stresses, strict=True)
        nodes = [
            stress_status(name, NodeFigures(*node), self.limits)
            for name, node in zip(self._nodes, figures, strict=True)
        ]
        pace = pace_status(PaceFigures(self._factor, self._wanted, self._window.lag), self.limits)
        return [*wheels, *nodes, pace, *([verdict_status(self._verdicts())] if self._limit_set else [])]

    def _stale(self, why: str) -> list[Status]:
        names = [*WHEELS, *(f"stress {node}" for node in self._nodes), "pacing"]
        names += ["verdict"] if self._limit_set else []
        known = {status.name: status for status in self._last}
        blank = Status("", Level.STALE, why)
        return [replace(known.get(name, blank), name=name, level=Level.STALE, message=why) for name in names]
