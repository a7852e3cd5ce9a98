"""Bags read back as the blocks of samples that were recorded, bit by bit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from ..errors import InputError, RecordingError
from ..samples.block import SampleBlock
from .losses import Damage, Gap
from .messages import State, start_of, state_of, stress_topic
from .run_info import RunInfo
from .sample_groups import WAITING, SampleGroups
from .source import FORCES, BagSource, Lost
from .window import EVERYTHING, Window

KINDS = (FORCES, "AxleStress", "SimulationState")
"""Messages that make up a run; all others are derived from them."""


@dataclass(frozen=True)
class Bag:
    """A bag that can be read, a file or a folder; topics are found by their types, so the prefix does not matter.

    Bags of ``ros2 bag record`` are read too, and those of other versions by the definitions that they hold. Every
    method raises RecordingError, in one line, if the bag is missing, damaged, has gaps or holds no run.
    """

    path: Path
    lost: Lost | None = None
    """Told of all that is missing or damaged while the bag is read, which is left out then; without it, the bag is
    refused."""

    @cached_property
    def source(self) -> BagSource:
        """The messages of the bag."""
        return BagSource(self.path, self.lost)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order."""
        return self.source.files

    @cached_property
    def info(self) -> RunInfo:
        """What the bag says about its run; a bag of ``ros2 bag record`` says what its first state message says."""
        if self.source.info:
            return self.source.info
        for state in self.states:
            return RunInfo(state.scenario_name, state.scenario, state.digest, math.nan, versions={})
        return RunInfo("unknown", "", "", math.nan, versions={})

    @cached_property
    def start_ns(self) -> int:
        """Time stamp of step 0, ns since the epoch."""
        for told in self.source.quiet.messages(KINDS):
            return start_of(told.message)
        raise self.nothing()

    @cached_property
    def states(self) -> tuple[State, ...]:
        """What was simulated: the state at the start, and one for every revision."""
        return tuple(self.each_state())

    def each_state(self) -> Iterator[State]:
        """The same, read as they are asked for."""
        return (state_of(told.message) for told in self.source.quiet.messages(("SimulationState",)))

    def blocks(self, window: Window = EVERYTHING, nodes: Sequence[str] | None = None) -> Iterator[SampleBlock]:
        """Blocks of the run in their order, as ``events`` yields them."""
        return (event for event in self.events(window, nodes) if isinstance(event, SampleBlock))

    def events(self, window: Window = EVERYTHING, nodes: Sequence[str] | None = None) -> Iterator[SampleBlock | State]:
        """Blocks, without gaps unless ``lost`` is told of them, and states where they stand in the bag.

        All blocks that have samples in ``window`` come whole, with all stress nodes or with ``nodes`` in their order;
        InputError names one that is not there.
        """
        self.source.tell_missing()
        groups = SampleGroups(self._stress_topics(nodes))
        before: SampleBlock | None = None
        wanted = {*groups.topics}
        for kind, topic, message in self.source.messages(
            KINDS, window, lambda kind, topic: kind != "AxleStress" or topic in wanted
        ):
            if kind == "SimulationState":
                yield state_of(message)
                continue
            if message.decimation != 1:
                raise RecordingError(
                    f"{self.path} holds only each {message.decimation}th step of {topic}: record it at full rate"
                )
            block = groups.add(topic if kind == "AxleStress" else "", message)
            if block is None:
                self._tell(groups.incomplete(WAITING) if self.lost else ())
            elif window.over(block.first_step, block.time):
                break
            elif window.touches(block):
                if before is not None and not self._follows(before, block):
                    break
                yield block
                before = block
        else:
            self._tell(groups.incomplete() if self.lost and window.whole else ())
        if before is None:
            raise self.nothing(window)

    def _follows(self, before: SampleBlock, block: SampleBlock) -> bool:
        """Whether a block comes after another; with a gap between them, or if it does not, it is told."""
        end, end_time = before.first_step + len(before), before.time + len(before) * before.step_period
        if block.first_step == end:
            return True
        if self.lost is None:
            raise RecordingError(
                f"{self.path} has a gap: after step {end - 1} comes step {block.first_step}, record it again or read "
                "it with its gaps"
            )
        if gap := Gap.between(end, end_time, block.first_step, block.time):
            self.lost(gap)
            return True
        self.lost(Damage.again(self.path.name, block.first_step, end))
        return False

    def _stress_topics(self, nodes: Sequence[str] | None) -> list[str]:
        there = self.source.quiet.topics("AxleStress")
        if nodes is None:
            return there
        found = []
        for node in nodes:
            topic = next((topic for topic in there if topic.endswith("/" + stress_topic(node))), None)
            if topic is None:
                names = ", ".join(topic.rpartition("/")[2] for topic in there) or "no stress node"
                raise InputError(f"{self.path} has no stress node {node}: it has {names}")
            found.append(topic)
        return found

    def _tell(self, reasons: Iterable[str]) -> None:
        for reason in reasons:
            assert self.lost is not None
            self.lost(Damage(self.path.name, 0, 0, reason))

    def nothing(self, window: Window = EVERYTHING) -> RecordingError:
        """Error for a bag that has no samples in a window."""
        if not window.whole:
            return RecordingError(f"{self.path} holds no samples {window}: info tells what it holds")
        return RecordingError(
            f"{self.path} holds no complete chunk of contact forces and stresses: give a bag of a run"
        )
