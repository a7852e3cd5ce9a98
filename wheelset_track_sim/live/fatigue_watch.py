"""Fatigue of a run while it streams: counted block by block, reported once a second, kept in a ledger."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..bags.messages import Message, fatigue_message
from ..errors import InputError, WheelsetTrackError
from ..fatigue.axle import AxleFatigue, NodeFatigue, TurningWheel
from ..fatigue.curve import Curve
from ..fatigue.ledger import LONGEST_NAME, Basis, LedgerEntry, changed_ledger, run_identity
from ..fatigue.rainflow import StressSpectrum
from ..fatigue.static_stress import check_loads, static_stress
from ..inputs.schema import check, quantity
from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..simulation.simulator import Simulator

PERIOD = 1.0
"""Simulated time from report to report, s."""
NEARLY = 1e-6
"""Steps by which rounding may move the instant of a report."""


@dataclass(frozen=True)
class FatigueSettings:
    """How a run's fatigue is counted, and where it is kept."""

    curve: Curve
    axle: str
    """Identity of the axle."""
    angles: int = quantity("", 4, 720, "the number of points around the axle", default=36)
    mark: float = quantity("rad", -2 * math.pi, 2 * math.pi, "the angle of the axle's mark from the top", default=0.0)
    checkpoint: float = quantity("m", 1.0, 1e9, "the distance from checkpoint to checkpoint", default=5000.0)
    ledger: Path | None = None
    """File in which checkpoints are kept; None for none."""

    def __post_init__(self) -> None:
        check(self)
        if not self.axle.strip() or len(self.axle) > LONGEST_NAME or not self.axle.isprintable():
            raise InputError(f"axle = {self.axle!r} is no name: give 1 to {LONGEST_NAME} printable characters")


@dataclass(frozen=True)
class PointSpectrum:
    """Cycles of one point of the axle."""

    next_step: int
    time: float
    """Of that step, s."""
    distance: float
    """m"""
    angle: float
    """From the axle's mark, rad."""
    spectrum: StressSpectrum
    """Of one channel."""


class FatigueWatch:
    """Fatigue of one run; its methods may be called from several threads."""

    def __init__(
        self, simulator: Simulator, settings: FatigueSettings, log: Callable[[str], object] = lambda told: None
    ) -> None:
        """Count from the next block of ``simulator`` on; ``log`` gets, in any thread, what cannot be counted or kept.

        Raises InputError for a scenario whose fatigue cannot be counted, or a ledger that cannot be used.
        """
        scenario = simulator.scenario
        static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
        wheel = TurningWheel.of(scenario)
        self._simulator, self.settings, self._log = simulator, settings, log
        self._count = AxleFatigue(static, wheel, settings.curve, points=settings.angles, mark=settings.mark)
        self._basis = Basis(settings.curve, settings.angles, self._count.gate)
        self._loads = scenario.loads
        self._begin = simulator.history[0].scenario.to_yaml()
        self._ended = False
        self._before = 0.0, self._count.damage[..., 0]
        self._every = math.ceil(settings.checkpoint / wheel.step_length)
        self._kept = 0
        self._lock = threading.RLock()
        self._disk = ThreadPoolExecutor(1, "ledger")
        self.stopped = ""
        """Why counting has stopped; empty if it has not."""
        if settings.ledger is not None:
            with changed_ledger(settings.ledger, self._basis):
                pass

    @property
    def time(self) -> float:
        """Simulated time of the next step to count, s."""
        return float(self._simulator.course.time_of(self._count.next_step or 0))

    @property
    def nodes(self) -> tuple[NodeFatigue, ...]:
        """Fatigue of each node so far."""
        with self._lock:
            return self._count.nodes

    def push(self, block: SampleBlock, start_ns: int) -> list[Message]:
        """Take in the next block; reports that are due in it. ``start_ns`` is the time stamp of step 0, ns."""
        if self.stopped or self._ended:
            return []
        with self._lock:
            try:
                if self._simulator.in_force.loads != self._loads:
                    check_loads([self._loads, self._simulator.in_force.loads])
            except InputError as refusal:
                self.stopped = str(refusal)
                self._log(f"fatigue is no longer counted: {refusal}")
                return []
            found = []
            for part, due in _cut(block):
                self._count.push(part)
                if due:
                    found.append(self.report(start_ns, block.revision))
            if self.settings.ledger is not None and self._count.steps - self._kept >= self._every:
                self._kept = self._count.steps
                self._keep(self.settings.ledger, self._entry(start_ns, finished=False))
            return found

    def report(self, start_ns: int, revision: int) -> Message:
        """What came of the run so far."""
        with self._lock:
            count, curve = self._count, self.settings.curve
            nodes = count.nodes
            distance, damage = count.steps * count.wheel.step_length, count.damage[..., 0]
            run_since, harm = distance - self._before[0], damage - self._before[1]
            self._before = distance, damage
            worst = [node.worst for node in nodes]
            window = 1e3 * harm[np.arange(len(nodes)), worst] / run_since if run_since > 0 else np.zeros(len(nodes))
            assert count.next_step is not None
            fields: dict[str, Any] = {
                "first_step": count.next_step - count.steps,
                "next_step": count.next_step,
                "distance": distance,
                "revision": revision,
                "axle": self.settings.axle,
                "run": run_identity(self._begin, start_ns),
                "curve": curve.name,
                "curve_source": curve.source,
                "curve_assumed": curve.assumed,
                "rules": [*curve.rules],
                "nodes": [node.name for node in nodes],
                "amplitude": _row(node.amplitude for node in nodes),
                "undamaged_amplitude": _row(node.undamaged_amplitude for node in nodes),
                "mean": _row(node.mean for node in nodes),
                "equivalent_range": _row(node.equivalent_range for node in nodes),
                "ratio": _row(node.ratios[0] for node in nodes),
                "worst_angle": _row(node.angle for node in nodes),
                "window_damage": np.ascontiguousarray(window),
                "angles": count.angles,
                "damage": np.ascontiguousarray(count.damage.reshape(-1)),
            }
            return fatigue_message(self.time, start_ns, fields)

    def spectrum(self, node: str, angle: float | None) -> PointSpectrum:
        """Cycles of the point of a node that is nearest to an angle, rad, or of the worst one.

        Raises InputError for a node that is not counted, and before the first block.
        """
        with self._lock:
            count = self._count
            names = count.static.nodes
            if node not in names:
                raise InputError(f"node = {node!r} is not counted: give one of {', '.join(names)}")
            if count.next_step is None:
                raise InputError("there is no step yet: activate the node first")
            row = names.index(node)
            if angle is None:
                point = count.nodes[row].worst
            else:
                if not math.isfinite(angle):
                    raise InputError(f"angle = {angle} is not finite: give an angle in rad, or worst")
                point = round(angle / (2 * math.pi) * len(count.angles)) % len(count.angles)
            distance = count.steps * count.wheel.step_length
            channel = row * len(count.angles) + point
            one = count.spectrum.channel(channel)
            return PointSpectrum(count.next_step, self.time, distance, float(count.angles[point]), one)

    def save(self, path: Path, start_ns: int) -> str:
        """Put the run so far into a ledger; what its entry was to it. Raises WheelsetTrackError."""
        with self._lock:
            if self._count.next_step is None:
                raise InputError("there is no step yet: activate the node first")
            entry = self._entry(start_ns, finished=False)
        return self._put(path, entry)

    def finish(self, start_ns: int) -> list[Message]:
        """End the count: a last report, and the finished entry in the ledger; doing it again does nothing."""
        with self._lock:
            if self._count.next_step is None or self._ended:
                return []
            self._ended = True
            last = [] if self.stopped else [self.report(start_ns, self._simulator.revision)]
            if self.settings.ledger is not None:
                self._keep(self.settings.ledger, self._entry(start_ns, finished=True))
        self._disk.shutdown()
        return last

    def _entry(self, start_ns: int, *, finished: bool) -> LedgerEntry:
        run, name = run_identity(self._begin, start_ns), self._simulator.scenario.name
        return LedgerEntry.of(self._count, self.settings.axle, run, name, finished=finished)

    def _keep(self, path: Path, entry: LedgerEntry) -> Future[None]:
        """Write an entry in a thread of its own: the stream waits for no disk."""

        def keep() -> None:
            try:
                self._put(path, entry)
            except WheelsetTrackError as refusal:
                self._log(f"fatigue is not kept: {refusal}")

        return self._disk.submit(keep)

    def _put(self, path: Path, entry: LedgerEntry) -> str:
        with changed_ledger(path, self._basis) as ledger:
            return ledger.put(entry)


def _cut(block: SampleBlock) -> Iterator[tuple[SampleBlock, bool]]:
    """Parts of a block, and whether a report is due after each: before the first step at or after a whole period.

    However a run is cut, reports are due at the same steps.
    """
    row = 0
    while row < len(block):
        steps = (block.time + row * block.step_period) / block.step_period
        of_period = PERIOD / block.step_period
        due = (math.floor((steps + NEARLY) / of_period) + 1) * of_period
        left = math.ceil(due - steps - NEARLY)
        part = block.part(row, min(row + left, len(block)))
        row += len(part)
        yield part, len(part) == left


def _row(values: Iterator[float]) -> Real:
    return np.array([*values], dtype=np.float64)
