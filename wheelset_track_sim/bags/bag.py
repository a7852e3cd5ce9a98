"""A bag read back as the blocks of samples that were recorded, bit by bit."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

from ..errors import InputError, RecordingError
from ..samples.block import SampleBlock
from .bag_reader import FORCES, SAMPLES, STRESS, BagReader, Lost
from .content import LAST, checked_block, checked_state, span_of
from .grouping import HELD, Group, Groups, by_step
from .losses import LONGEST_GAP, Damage, Gap
from .messages import State, start_of, stress_topic
from .run_info import RunInfo
from .window import EVERYTHING, RunWindow

STATE = "SimulationState"
KINDS = (*SAMPLES, STATE)
"""Messages that make up a run; all others are derived from them."""


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
        for start in self.reader.quiet.messages(KINDS, start_of):
            return start
        raise self.nothing()

    @cached_property
    def states(self) -> tuple[State, ...]:
        """The state at the start of the bag, and one for every revision."""
        return tuple(self.each_state())

    def each_state(self) -> Iterator[State]:
        """The same, each read when it is needed."""
        return self.reader.quiet.messages((STATE,), checked_state)

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
        groups = Groups((FORCES, *self._stress_topics(nodes)))
        states: deque[State] = deque()
        found = self._complete(groups, window, states.append)
        if self.reader.disordered:
            found = by_step(found, lambda block: block.forces.nbytes + block.stresses.nbytes)
        before: SampleBlock | None = None
        over = False
        for event in found:
            while states:
                yield states.popleft()
            if window.over(event.first_step, event.time):
                break
            if not window.touches(event):
                continue
            over = before is not None and not self._follows(before, event, groups)
            if over:
                break
            if not self.reader.disordered:  # what is incomplete before it stays so
                self._leave_out(groups, groups.taken(event.first_step), window)
            yield event
            before = event
        yield from states
        if not over:
            self._leave_out(groups, groups.taken(2 * LAST), window)
        if before is None:
            raise self.nothing(window)

    def _complete(self, groups: Groups, window: RunWindow, tell: Callable[[State], object]) -> Iterator[SampleBlock]:
        """Blocks, each when the last of its messages has come; ``tell`` is called with the states between them."""
        for found in self.reader.stored(KINDS, window):
            topic = found.message.topic
            signal = FORCES if topic.kind == FORCES else topic.name
            if topic.kind != STATE and signal not in groups.signals:
                continue
            message = self.reader.decoded(found)
            if message is None:
                continue
            if topic.kind == STATE:
                state = self.reader.made(found, partial(checked_state, message))
                if state is not None:
                    tell(state)
                continue
            if self.reader.made(found, partial(span_of, message)) is None:
                continue
            if message.decimation != 1:
                raise RecordingError(
                    f"{self.path} holds only every {message.decimation}th step of {topic.name}: record it at full rate"
                )
            group = self.reader.made(found, partial(groups.add, signal, message, len(found.message.data)))
            if group is None:
                self._leave_out(groups, groups.oldest(HELD), window)
                continue
            forces, *stresses = (group.messages[signal] for signal in groups.signals)
            block = self.reader.made(found, partial(checked_block, forces, stresses))
            if block is not None:
                yield block

    def _follows(self, before: SampleBlock, block: SampleBlock, groups: Groups) -> bool:
        """Whether a block comes after another, with or without a gap, which is reported."""
        end, end_time = before.first_step + len(before), before.time + len(before) * before.step_period
        if block.first_step == end:
            return True
        again = Damage.again(self.path.name, block.first_step, end)
        if self.lost is None:
            for group in groups:
                if end <= group.first_step < block.first_step:
                    raise self._incomplete(group.missing(groups.signals, FORCES))
            if block.first_step < end:
                raise self._incomplete(again.what)
            raise RecordingError(
                f"{self.path} has a gap, step {block.first_step} follows step {end - 1}: record it again, or pass "
                "lost= to read past it"
            )
        if block.first_step - end > LONGEST_GAP:
            self.lost(Damage.far(self.path.name, block.first_step, end))
            return False
        if gap := Gap.between(end, end_time, block.first_step, block.time):
            self.lost(gap)
            return True
        self.lost(again)
        return False

    def _leave_out(self, groups: Groups, incomplete: Iterable[Group], window: RunWindow) -> None:
        """Report incomplete groups that have samples in a window; without ``lost``, they are rejected."""
        for group in incomplete:
            some = next(iter(group.messages.values()))
            last = span_of(some) - 1
            if window.meets(some.first_step, some.time, some.first_step + last, some.time + last * some.step_period):
                reason = group.missing(groups.signals, FORCES)
                if self.lost is None:
                    raise self._incomplete(reason)
                self.lost(Damage(self.path.name, 0, 0, reason))

    def _incomplete(self, reason: str) -> RecordingError:
        return RecordingError(
            f"{self.path} is not a complete bag ({reason}): record it again, or pass lost= to read past the damage"
        )

    def _stress_topics(self, nodes: Sequence[str] | None) -> list[str]:
        there = self.reader.topics(STRESS)
        if nodes is None:
            return there
        found = []
        for node in nodes:
            topic = next((topic for topic in there if topic.endswith("/" + stress_topic(node))), None)
            if topic is None:
                names = ", ".join(topic.rpartition("/")[2] for topic in there) or "none"
                raise InputError(f"{self.path} has no stress node {node}: give one of {names}")
            found.append(topic)
        return found

    def nothing(self, window: RunWindow = EVERYTHING) -> RecordingError:
        """Error for a bag that has no samples in a window."""
        if not window.whole:
            return RecordingError(f"{self.path} holds no samples {window}: info lists what it holds")
        return RecordingError(
            f"{self.path} holds no complete chunk of contact forces and stresses: give a bag of a run"
        )
