"""What is watched while a run streams: impacts, and the peaks of each turn."""

from __future__ import annotations

from dataclasses import dataclass

from ..samples.block import SampleBlock
from ..samples.impacts import Impact, ImpactDetector, ImpactSettings
from ..samples.summary import Summary
from ..samples.turns import TurnPeaks, TurnWatch
from ..simulation.simulator import Simulator


@dataclass(frozen=True)
class Seen:
    """What a block brought."""

    impacts: list[Impact]
    """Those that are over, in the order in which they ended."""
    turn: TurnPeaks
    """The last complete turn of the wheels."""
    turns: tuple[TurnPeaks, ...] = ()
    """Those that were completed in the block."""


class Watch:
    """Impacts and turns of one run; nothing depends on how the run is cut into blocks."""

    def __init__(self, simulator: Simulator, settings: ImpactSettings | None = None) -> None:
        """For the blocks of ``simulator`` from the next one on."""
        self._simulator = simulator
        self.detector = ImpactDetector(simulator.steps_per_revolution, simulator.models.tread_origin, settings)
        self._turns = TurnWatch(simulator.steps_per_revolution)

    def push(self, block: SampleBlock, summary: Summary) -> Seen:
        """What the latest block of the simulator, with its own ``summary``, brings."""
        impacts = self.detector.push(block, self._simulator.in_force.wheel_load, summary)
        turns = tuple(self._turns.push(block, summary))
        return Seen(impacts, self._turns.last, turns)

    def finish(self) -> list[Impact]:
        """Impacts that are not over at the end of the run, as they stand."""
        return self.detector.finish()
