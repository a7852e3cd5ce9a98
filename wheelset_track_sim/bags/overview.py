"""What a bag holds, from its small messages, and whether it holds every sample of every signal.

The values of samples are read only if there are no summaries of them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError, RecordingError
from ..inputs.yaml12 import parse
from ..samples.block import UNCOUNTED, ContactCounts, SampleBlock
from ..samples.summary import NodeStress, Summary, WheelLoad, combine, summarise
from .bag import STATE, Bag
from .bag_reader import FORCES, SAMPLES, BagReader, Located
from .content import BEYOND, ContentError, check_finite, check_place, checked_state, checked_wheel, span_of
from .grouping import Groups, by_step
from .losses import LONGEST_GAP, Damage, Gap, Loss
from .mcap.reader import McapReader
from .messages import start_of
from .run_info import Input, RunInfo, in_order

SUMMARY, IMPACT = "LoadSummary", "WheelImpact"
SMALL = (SUMMARY, STATE, IMPACT)


class TopicCount(NamedTuple):
    """A topic of a bag."""

    type: str
    messages: int


class ChangedKey(NamedTuple):
    """A key of a scenario with its value before and after a change; None if it is missing there."""

    key: str
    """Dotted path, such as ``irregularities.0.h``."""
    before: Any
    after: Any


@dataclass(frozen=True)
class RecordedRevision:
    """A change that has taken effect."""

    number: int
    step: int
    """First step with the change."""
    changed: tuple[ChangedKey, ...]
    """Compared with the revision before in the bag."""


@dataclass(frozen=True)
class Overview:
    """What a bag holds."""

    path: Path
    files: dict[str, int]
    """Size of each file, bytes."""
    info: RunInfo
    start_ns: int | None
    """Time stamp of step 0, ns since the epoch; None if there are no samples."""
    topics: dict[str, TopicCount]
    first_step: int
    steps: int
    """Steps with every signal."""
    start: float
    """Simulated time of the first sample, s."""
    duration: float
    """Of these steps, s."""
    summary: Summary | None
    """Of all samples, as the bag itself sums them up; of the samples if it does not."""
    revisions: tuple[RecordedRevision, ...]
    impacts: tuple[int, int]
    """Number of impacts of each wheel."""
    losses: tuple[Loss, ...]
    unchecked: tuple[str, ...] = ()
    """What the verdict leaves open, a line each."""

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Steps that are missing in between."""
        return tuple(loss for loss in self.losses if isinstance(loss, Gap))

    @property
    def complete(self) -> bool:
        """Whether all files are there, closed and undamaged, with every sample of every signal from first to last."""
        return not self.losses


@dataclass(frozen=True)
class _Piece:
    """Consecutive samples."""

    first_step: int
    samples: int
    time: float
    step_period: float
    summary: Summary | None = None

    def __len__(self) -> int:
        return self.samples


class _Total:
    """Pieces put together."""

    def __init__(self, bag: str) -> None:
        self.first: _Piece | None = None
        self.steps, self.duration = 0, 0.0
        self.losses: list[Loss] = []
        self.summary: Summary | None = None
        self.over = False
        """Whether another run has begun, which does not count."""
        self.end_step, self._end_time = 0, 0.0
        self._bag = bag

    def add(self, piece: _Piece) -> None:
        if self.over:
            return
        if self.first is None:
            self.first = piece
        elif piece.first_step < self.end_step or piece.first_step - self.end_step > LONGEST_GAP:
            ends = Damage.again if piece.first_step < self.end_step else Damage.far
            self.losses.append(ends(self._bag, piece.first_step, self.end_step))
            self.over = True
            return
        elif gap := Gap.between(self.end_step, self._end_time, piece.first_step, piece.time):
            self.losses.append(gap)
        self.steps += piece.samples
        self.duration += piece.samples * piece.step_period
        if piece.summary:
            self.summary = piece.summary if self.summary is None else combine([self.summary, piece.summary])
        self.end_step, self._end_time = piece.first_step + piece.samples, piece.time + piece.samples * piece.step_period


class _Pass:
    """One pass through the messages of a bag."""

    def __init__(self, bag: Bag, losses: list[Loss]) -> None:
        self._reader: BagReader = bag.reader
        self._losses = losses
        self.counts: Counter[str] = Counter()
        self.types: dict[str, str] = {}
        self.impacts = [0, 0]
        self.inputs: list[Input] = []
        self.start_ns: int | None = None
        self.summaries: list[_Piece] = []
        self.blocks: list[_Piece] = []
        self.signals: dict[str, list[_Piece]] = {}
        self.factors: dict[str, set[int]] = {}
        """Steps from sample to sample, by signals."""
        self.groups = Groups((FORCES, *self._reader.topics("AxleStress")))
        self._held: Counter[tuple[str, str]] = Counter()
        self._files: dict[str, McapReader] = {}
        for found in self._reader.stored((FORCES,)):
            self._take(found)
        self._compare_counts()

    def _take(self, found: Located) -> None:
        topic = found.message.topic
        self.counts[topic.name] += 1
        self.types.setdefault(topic.name, topic.type)
        self._held[found.mcap.name, topic.name] += 1
        self._files[found.mcap.name] = found.mcap
        message = self._reader.decoded(found) if topic.kind in (*SMALL, *SAMPLES) else None
        if message is not None:
            self._reader.made(found, lambda: self._note(topic.kind, topic.name, message, len(found.message.data)))

    def _note(self, kind: str, topic: str, message: Any, size: int) -> None:
        if kind == SUMMARY:
            self.summaries.append(_piece(message))
        elif kind == IMPACT:
            self.impacts[checked_wheel(message.wheel)] += 1
        elif kind == STATE:
            state = checked_state(message)
            self.inputs.append(Input(state.revision, state.first_step, state.scenario))
        elif kind == FORCES or topic in self.groups.signals:
            factor = int(message.decimation)
            samples = span_of(message) * factor
            check_finite(message)
            place = _Piece(message.first_step, samples, float(message.time), float(message.step_period) / factor)
            signal = FORCES if kind == FORCES else topic
            self.signals.setdefault(signal, []).append(place)
            self.factors.setdefault(signal, set()).add(factor)
            group = self.groups.add(signal, place, 0)
            if group is not None:
                if len({piece.samples for piece in group.messages.values()}) > 1:
                    raise ContentError(f"signals from step {group.first_step} on differ in their numbers of samples")
                self.blocks.append(place)
        self.start_ns = start_of(message) if self.start_ns is None else self.start_ns

    def _compare_counts(self) -> None:
        """Report messages that the statistics of a file count, and that are not there."""
        damaged = {loss.file for loss in self._losses if isinstance(loss, Damage)}
        for file, mcap in self._files.items():
            for topic, count in (mcap.counts or {}).items() if file not in damaged else ():
                held = self._held[file, topic]
                if held < count:
                    self._losses.append(Damage(file, 0, 0, f"it holds {held} of the {count} messages of {topic}"))


def overview(path: str | Path) -> Overview:
    """Overview of a bag, damaged or not; memory grows by some bytes for each of its messages.

    Raises RecordingError if it is missing, cannot be opened, holds no message that can be read, or was recorded with
    definitions that cannot be read.
    """
    losses: list[Loss] = []
    bag = Bag(Path(path), losses.append)
    reader = bag.reader
    reader.report_missing()
    seen = _Pass(bag, losses)
    if not seen.counts:
        why = f" ({losses[0]})" if losses else ""
        raise RecordingError(f"{reader.path} holds no message that can be read{why}: give a bag of a run")
    decimated = any(factors != {1} for factors in seen.factors.values())
    found = seen.signals.get(FORCES, []) if decimated else seen.blocks
    blocks, summaries = (_total(reader, pieces) for pieces in (found, seen.summaries))
    run = blocks if blocks.first else summaries
    losses += run.losses
    unchecked = ["whether the extremes of the samples equal the extremes in the summaries of the bag, which are shown"]
    if decimated:
        losses += _uneven(reader, seen)
        unchecked.append("whether each step has every signal: they do not have samples at each step")
    else:
        losses += _incomplete(seen.groups, blocks, reader.path.name)
        losses += _unequal(blocks, summaries, reader.path.name)
    if run.first is None:
        unchecked = ["whether it is whole: it holds no samples of a run"]
    elif summaries.summary is None:
        unchecked = []
        for block in _blocks(bag):
            part = replace(summarise(block), contacts=UNCOUNTED)
            summaries.summary = part if summaries.summary is None else combine([summaries.summary, part])
    unchecked += [f"{file} is left out" for file in reader.folder.left_out]
    return Overview(
        path=reader.path,
        files={file.name: file.stat().st_size for file in reader.files},
        info=bag.info,
        start_ns=seen.start_ns,
        topics={topic: TopicCount(seen.types[topic], seen.counts[topic]) for topic in sorted(seen.counts)},
        first_step=run.first.first_step if run.first else 0,
        steps=blocks.steps,
        start=run.first.time if run.first else 0.0,
        duration=blocks.duration,
        summary=summaries.summary,
        revisions=revisions_of([*bag.info.inputs, *seen.inputs]),
        impacts=(seen.impacts[0], seen.impacts[1]),
        losses=tuple(dict.fromkeys(losses)),  # reading a bag twice reports some of them twice
        unchecked=tuple(unchecked),
    )


def _total(reader: BagReader, pieces: list[_Piece]) -> _Total:
    """Pieces put together, in the order of their steps if the bag has them in none."""
    total = _Total(reader.path.name)
    for piece in by_step(pieces, lambda _: 0) if reader.disordered else pieces:
        total.add(piece)
    return total


def _incomplete(groups: Groups, blocks: _Total, bag: str) -> list[Loss]:
    """Samples that some signals lack, of the run that counts."""
    left = [group for group in groups if not blocks.over or group.first_step >= blocks.end_step]
    return [Damage(bag, 0, 0, group.missing(groups.signals, FORCES)) for group in left]


def _uneven(reader: BagReader, seen: _Pass) -> Iterator[Loss]:
    """Gaps of signals that have samples each some steps, and signals that do not keep to that."""
    for signal, pieces in seen.signals.items():
        name, factors = ("contact forces" if signal == FORCES else signal), sorted(seen.factors[signal])
        if len(factors) > 1:
            words = f"{name} have samples each {' and each '.join(map(str, factors))} steps"
            yield Damage(reader.path.name, 0, 0, words)
        elif signal != FORCES:
            yield from (Damage(reader.path.name, 0, 0, f"{name}: {loss}") for loss in _total(reader, pieces).losses)


def _unequal(blocks: _Total, summaries: _Total, bag: str) -> list[Loss]:
    """Steps with samples and no summary, or with a summary and no samples, that are reported by nothing else."""
    if summaries.first is None or blocks.over or summaries.over:
        return []
    begin, end = summaries.first.first_step, summaries.end_step
    if blocks.first is None:
        return [Damage(bag, 0, 0, f"steps {begin} to {end - 1} have summaries and no complete samples")]
    known = {(gap.first_step, gap.steps) for gap in blocks.losses if isinstance(gap, Gap)}
    first, last = blocks.first.first_step, blocks.end_step
    inside = [(gap.first_step, gap.steps) for gap in summaries.losses if isinstance(gap, Gap)]
    lacking = [(step, step + steps) for step, steps in inside if (step, steps) not in known]
    lacking += [(first, min(begin, last)), (max(end, first), last)]
    surplus = [(begin, min(end, first)), (max(begin, last), end)]
    return [
        Damage(bag, 0, 0, f"steps {step} to {stop - 1} have {what}")
        for what, spans in (("no summary, so the extremes are without them", lacking), ("a summary alone", surplus))
        for step, stop in spans
        if step < stop
    ]


def _piece(message: Any) -> _Piece:
    """A piece from a LoadSummary; ContentError if it is none of a run."""
    check_place(message)
    wheels = [
        WheelLoad(**{name: getattr(message, f"wheel_{wheel}_{name}") for name in WheelLoad.__dataclass_fields__})
        for wheel in (1, 2)
    ]
    figures = [getattr(message, f"max_principal_{name}") for name in ("max", "min", "mean", "rms")]
    if any(len(found) != len(message.nodes) for found in figures):
        raise ContentError(f"it names {len(message.nodes)} nodes, and has the extremes of others")
    nodes = tuple(NodeStress(name, *map(float, found)) for name, *found in zip(message.nodes, *figures, strict=True))
    if any((np.abs(found) >= BEYOND).any() for found in figures):
        raise ContentError(f"extremes of stresses from step {message.first_step} on are beyond {BEYOND:g} Pa")
    samples = int(message.samples)
    if not samples:
        raise ContentError("it holds no samples")
    for wheel, load in enumerate(wheels, start=1):
        for name, value in vars(load).items():
            if not abs(value) < BEYOND:
                raise ContentError(f"{name} of wheel {wheel} from step {message.first_step} on is {value}")
    return _Piece(
        int(message.first_step),
        samples,
        float(message.time),
        float(message.step_period),
        Summary(samples, (wheels[0], wheels[1]), nodes, _contacts(message)),
    )


def _contacts(message: Any) -> ContactCounts:
    return ContactCounts(int(message.solved_steps), int(message.filtered_steps), float(message.largest_estimate))


def _blocks(bag: Bag) -> Iterator[SampleBlock]:
    """Blocks of samples; none if there are none."""
    try:
        yield from bag.blocks()
    except RecordingError:
        return


def revisions_of(inputs: Iterable[Input]) -> tuple[RecordedRevision, ...]:
    """Revisions in their order, with the keys that each changed."""
    return tuple(
        RecordedRevision(now.revision, now.step, changed_keys(before.scenario, now.scenario) if before else ())
        for before, now in pairwise([None, *in_order(inputs)])
        if now is not None
    )


def changed_keys(before: str, after: str) -> tuple[ChangedKey, ...]:
    """Keys with different values in two scenarios, which are YAML texts."""
    # A scenario holds the descriptions of its models: only the sections that differ are parsed.
    old, new = _sections(before), _sections(after)
    texts = ["".join(part for part in one if part not in other) for one, other in ((old, new), (new, old))]
    try:
        before_it, after_it = (parse(text, "scenario", trusted=False) or {} for text in texts)
        to_come = [each.pop("events", None) or [] for each in (before_it, after_it) if isinstance(each, dict)]
        changed = tuple(_changed("", before_it, after_it))
    except InputError:  # of another version or by hand
        return (ChangedKey("scenario", before, after),) if before != after else ()
    counts = [len(each) for each in to_come if isinstance(each, list)]
    return (*changed, ChangedKey("events to come", *counts)) if any(counts) and len(counts) == 2 else changed


def _sections(text: str) -> list[str]:
    """A YAML mapping, cut at its top-level keys."""
    return re.split(r"(?m)^(?=[^\s#-])", text)


def _changed(key: str, before: Any, after: Any) -> Iterable[ChangedKey]:
    if isinstance(before, dict) and isinstance(after, dict):
        names = [*before, *(name for name in after if name not in before)]
    elif isinstance(before, list) and isinstance(after, list):
        names = [*range(max(len(before), len(after)))]
        before, after = dict(enumerate(before)), dict(enumerate(after))
    elif before != after:
        yield ChangedKey(key.removeprefix("."), before, after)
        return
    else:
        return
    for name in names:
        yield from _changed(f"{key}.{name}", before.get(name), after.get(name))
