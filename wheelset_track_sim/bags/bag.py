"""A bag read back as the blocks of samples that were recorded, bit by bit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..errors import InputError, RecordingError
from ..samples.block import SampleBlock
from .bag_reader import FORCES, BagReader, Lost
from .losses import Damage, Gap
from .messages import State, block_of, start_of, state_of, stress_topic
from .run_info import RunInfo
from .window import EVERYTHING, RunWindow

KINDS = (FORCES, "AxleStress", "SimulationState")
"""Messages that make up a run; all others are derived from them."""
WAITING = 64
"""Chunks of samples that wait for the rest of their messages; in a bag of this package none does."""


@dataclass(frozen=True)
class Bag:
    """A bag that can be read, a file or a folder; topics are found by their types, so the prefix does not matter.

    Bags of ``ros2 bag record`` are read too, and those of other versions by the definitions that they hold. Every
    method raises RecordingError, in one line, if the bag is missing, damaged, has gaps or holds no run.
    """

    path: Path
    lost: Lost | None = None
    """Called with each missing or damaged part, which is left out then; without it, such a bag is rejected."""

    @cached_property
    def reader(self) -> BagReader:
        """The messages of the bag."""
        return BagReader(self.path, self.lost)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order."""
        return self.reader.files

    @cached_property
    def info(self) -> RunInfo:
        """Origin of the run; for a bag of ``ros2 bag record``, as far as its first state message describes it."""
        if self.reader.info:
            return self.reader.info
        for state in self.states:
            return RunInfo(state.scenario_name, state.scenario, state.digest, math.nan, versions={})
        return RunInfo("unknown", "", "", math.nan, versions={})

    @cached_property
    def start_ns(self) -> int:
        """Time stamp of step 0, ns since the epoch."""
        for message in self.reader.quiet.messages(KINDS):
            return start_of(message)
        raise self.nothing()

    @cached_property
    def states(self) -> tuple[State, ...]:
        """The state at the start of the bag, and one for every revision."""
        return tuple(self.each_state())

    def each_state(self) -> Iterator[State]:
        """The same, each read when it is needed."""
        return (state_of(message) for message in self.reader.quiet.messages(("SimulationState",)))

    def blocks(self, window: RunWindow = EVERYTHING, nodes: Sequence[str] | None = None) -> Iterator[SampleBlock]:
        """Blocks of the run in their order, as ``events`` yields them."""
        return (event for event in self.events(window, nodes) if isinstance(event, SampleBlock))

    def events(
        self, window: RunWindow = EVERYTHING, nodes: Sequence[str] | None = None
    ) -> Iterator[SampleBlock | State]:
        """Blocks, and states between them in the order of the bag; gaps are reported to ``lost``, or rejected.

        All blocks that have samples in ``window`` are complete, with all stress nodes or with ``nodes`` in their order;
        InputError names a node that is not there.
        """
        self.reader.report_missing()
        stresses = self._stress_topics(nodes)
        waiting: dict[int, dict[str, Any]] = {}  # messages by topic, of chunks that are incomplete
        before: SampleBlock | None = None
        for found in self.reader.stored(KINDS, window):
            topic = found.message.topic
            if topic.kind not in KINDS or (topic.kind == "AxleStress" and topic.name not in stresses):
                continue
            message = self.reader.decoded(found)
            if message is None:
                continue
            if topic.kind == "SimulationState":
                yield state_of(message)
                continue
            if message.decimation != 1:
                raise RecordingError(
                    f"{self.path} holds only each {message.decimation}th step of {topic.name}: record it at full rate"
                )
            chunk = waiting.setdefault(message.first_step, {})
            chunk[topic.name if topic.kind == "AxleStress" else FORCES] = message
            if len(chunk) <= len(stresses):
                self._leave_out(waiting, stresses, WAITING)
                continue
            del waiting[message.first_step]
            block = block_of(chunk[FORCES], [chunk[name] for name in stresses])
            if window.over(block.first_step, block.time):
                break
            if window.touches(block):
                if before is not None and not self._follows(before, block):
                    break
                yield block
                before = block
        else:
            if window.whole:
                self._leave_out(waiting, stresses, 0)
        if before is None:
            raise self.nothing(window)

    def _follows(self, before: SampleBlock, block: SampleBlock) -> bool:
        """Whether a block comes after another, with or without a gap, which is reported."""
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

    def _leave_out(self, waiting: dict[int, dict[str, Any]], stresses: Sequence[str], most: int) -> None:
        """Report the oldest incomplete chunks, until only ``most`` are left; without ``lost``, keep them all."""
        while self.lost and len(waiting) > most:
            first_step = next(iter(waiting))
            chunk = waiting.pop(first_step)
            missing = ", ".join(
                topic if topic != FORCES else "contact forces" for topic in (FORCES, *stresses) if topic not in chunk
            )
            reason = f"samples from step {first_step} on are incomplete without {missing}"
            self.lost(Damage(self.path.name, 0, 0, reason))

    def _stress_topics(self, nodes: Sequence[str] | None) -> list[str]:
        there = self.reader.quiet.topics("AxleStress")
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

    def nothing(self, window: RunWindow = EVERYTHING) -> RecordingError:
        """Error for a bag that has no samples in a window."""
        if not window.whole:
            return RecordingError(f"{self.path} holds no samples {window}: info tells what it holds")
        return RecordingError(
            f"{self.path} holds no complete chunk of contact forces and stresses: give a bag of a run"
        )
