"""What a bag holds, from its small messages; samples are read only if there are no summaries of them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, RecordingError
from ..inputs.yaml12 import parse
from ..samples.summary import NodeStress, Summary, WheelLoad, combine, summarise
from .bag import Bag
from .bag_reader import FORCES
from .losses import Damage, Gap, Loss
from .messages import start_of, state_of
from .run_info import Input, RunInfo, in_order

SMALL = ("LoadSummary", "SimulationState", "WheelImpact")


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
    """A change that has come into force."""

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
    start: float
    """Simulated time of the first sample, s."""
    duration: float
    """Of all samples that are there, s."""
    summary: Summary | None
    """Of all samples that are there."""
    revisions: tuple[RecordedRevision, ...]
    impacts: tuple[int, int]
    """Number of impacts of each wheel."""
    losses: tuple[Loss, ...]

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Steps that are missing in between."""
        return tuple(loss for loss in self.losses if isinstance(loss, Gap))

    @property
    def complete(self) -> bool:
        """Whether all files are there, closed and undamaged, without gaps between their samples."""
        return not self.losses


class _Piece(NamedTuple):
    """Consecutive samples in scalars."""

    first_step: int
    time: float
    step_period: float
    summary: Summary


class _Total:
    """Pieces put together."""

    def __init__(self, bag: str, losses: list[Loss]) -> None:
        self.first: _Piece | None = None
        self.steps, self.duration = 0, 0.0
        self.summary: Summary | None = None
        self.over = False
        """Whether another run has begun, which does not count."""
        self._bag, self._losses = bag, losses
        self._end = 0, 0.0

    def add(self, piece: _Piece) -> None:
        length = piece.summary.samples
        if self.first is None:
            self.first = piece
        elif piece.first_step < self._end[0]:
            self._losses.append(Damage.again(self._bag, piece.first_step, self._end[0]))
            self.over = True
            return
        elif gap := Gap.between(*self._end, piece.first_step, piece.time):
            self._losses.append(gap)
        self.steps += length
        self.duration += length * piece.step_period
        self.summary = piece.summary if self.summary is None else combine([self.summary, piece.summary])
        self._end = piece.first_step + length, piece.time + length * piece.step_period


def overview(path: str | Path) -> Overview:
    """Overview of a bag, damaged or not; memory does not grow with its length.

    Raises RecordingError if it is missing, cannot be opened or was recorded with definitions that cannot be read.
    """
    losses: list[Loss] = []
    bag = Bag(Path(path), losses.append)
    reader = bag.reader
    reader.report_missing()
    total = _Total(reader.path.name, losses)
    counts: Counter[str] = Counter()
    types: dict[str, str] = {}
    impacts = [0, 0]
    inputs: list[Input] = []
    start_ns: int | None = None
    for found in reader.stored((FORCES,)):
        topic = found.message.topic
        counts[topic.name] += 1
        types.setdefault(topic.name, topic.type)
        message = reader.decoded(found) if topic.kind in SMALL and not total.over else None
        if message is None:
            continue
        start_ns = start_of(message) if start_ns is None else start_ns
        if topic.kind == "LoadSummary":
            total.add(_piece(message))
        elif topic.kind == "WheelImpact":
            impacts[message.wheel - 1] += 1
        else:
            state = state_of(message)
            inputs.append(Input(state.revision, state.first_step, state.scenario))
    if total.first is None:  # nobody recorded summaries
        for piece in _pieces(bag):
            total.add(piece)
    first = total.first
    return Overview(
        path=reader.path,
        files={file.name: file.stat().st_size for file in reader.files},
        info=bag.info,
        start_ns=start_ns,
        topics={topic: TopicCount(types[topic], counts[topic]) for topic in sorted(counts)},
        first_step=first.first_step if first else 0,
        steps=total.steps,
        start=first.time if first else 0.0,
        duration=total.duration,
        summary=total.summary,
        revisions=revisions_of([*bag.info.inputs, *inputs]),
        impacts=(impacts[0], impacts[1]),
        losses=tuple(dict.fromkeys(losses)),  # reading a bag twice reports some of them twice
    )


def _piece(message: Any) -> _Piece:
    """A piece from a LoadSummary."""
    wheels = [
        WheelLoad(**{name: getattr(message, f"wheel_{wheel}_{name}") for name in WheelLoad.__dataclass_fields__})
        for wheel in (1, 2)
    ]
    figures = (getattr(message, f"max_principal_{name}") for name in ("max", "min", "mean", "rms"))
    nodes = tuple(NodeStress(name, *map(float, found)) for name, *found in zip(message.nodes, *figures, strict=True))
    return _Piece(
        int(message.first_step),
        float(message.time),
        float(message.step_period),
        Summary(int(message.samples), (wheels[0], wheels[1]), nodes),
    )


def _pieces(bag: Bag) -> Iterator[_Piece]:
    """Pieces from samples; none if there are none."""
    try:
        for block in bag.blocks():
            yield _Piece(block.first_step, block.time, block.step_period, summarise(block))
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
        return tuple(_changed("", *(parse(text, "scenario") or {} for text in texts)))
    except InputError:  # of another version or by hand
        return (ChangedKey("scenario", before, after),) if before != after else ()


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
