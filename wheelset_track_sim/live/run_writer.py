"""A bag of a simulator's run, without ROS: chunks, what is seen in them, and each change."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from ..bags.settings import RecordSettings
from ..bags.snapshots import writer_of
from ..samples.block import SampleBlock
from ..samples.impacts import ImpactSettings
from ..samples.summary import Summary
from ..simulation.simulator import Simulator
from .origin import run_info, state, states
from .watch import Watch

if TYPE_CHECKING:
    from typing_extensions import Self


class RunWriter:
    """Records a simulator from its next block on; a context manager, as every writer is."""

    def __init__(
        self,
        path: str | Path,
        simulator: Simulator,
        *,
        start_ns: int = 0,
        settings: RecordSettings | None = None,
        impacts: ImpactSettings | None = None,
    ) -> None:
        """Create the bag; ``start_ns`` is the time stamp of step 0, ns. Raises InputError as ``BagWriter`` does.

        ``settings`` say how it is recorded, ``impacts`` what makes an impact.
        """
        self._simulator = simulator
        self._watch = Watch(simulator, impacts)
        self._told = simulator.revision
        self._set_point = simulator.course.at(simulator.next_step).set_point
        self._bag = writer_of(Path(path), run_info(simulator), settings or RecordSettings(), start_ns=start_ns)

    def __enter__(self) -> Self:
        with ExitStack() as stack:
            stack.enter_context(self._bag)
            self._bag.write_state(state(self._simulator))
            stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._bag.__exit__(kind, error, traceback)

    def push(self, block: SampleBlock, summary: Summary) -> None:
        """Record the latest block of the simulator with its ``summary``; RecordingError if the disk refuses."""
        set_point = self._simulator.course.at(block.first_step).set_point
        if (block.revision, set_point) != (self._told, self._set_point):
            for found in states(self._simulator, block, self._told):
                self._bag.write_state(found)
            self._told, self._set_point = block.revision, set_point
        seen = self._watch.push(block, summary)
        self._bag.write(block, summary=summary, turn=seen.turn, impacts=seen.impacts)

    def finish(self) -> None:
        """Record impacts that are not over at the end of the run, as they stand."""
        self._bag.write_impacts(self._watch.finish())
