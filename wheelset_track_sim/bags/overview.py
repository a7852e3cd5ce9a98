"""What is in a bag, from its small messages: the samples are not looked at if there are summaries of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import RecordingError
from ..samples.summary import NodeStress, Summary, WheelLoad, combine, summarise
from .bag import Bag
from .inputs import Input
from .losses import Damage, Gap, Loss
from .messages import start_of, state_of
from .revisions import Revision, revisions
from .run_info import RunInfo
from .source import FORCES, BagSource, kind_of

SMALL = ("LoadSummary", "SimulationState", "WheelImpact")


class TopicCount(NamedTuple):
    """A topic of a bag."""

    type: str
    messages: int


@dataclass(frozen=True)
class Overview:
    """What is in a bag."""

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
    revisions: tuple[Revision, ...]
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
    source = BagSource(Path(path), losses.append)
    source.tell_missing()
    total = _Total(source.path.name, losses)
    counts: Counter[str] = Counter()
    types: dict[str, str] = {}
    impacts = [0, 0]
    inputs: list[Input] = []
    start_ns: int | None = None
    for stored in source.stored((FORCES,)):
        topic, kind = stored.message.channel.topic, kind_of(stored.message.schema)
        counts[topic] += 1
        types.setdefault(topic, stored.message.schema.name)
        told = source.told(stored) if kind in SMALL and not total.over else None
        if told is None:
            continue
        start_ns = start_of(told.message) if start_ns is None else start_ns
        if kind == "LoadSummary":
            total.add(_piece(told.message))
        elif kind == "WheelImpact":
            impacts[told.message.wheel - 1] += 1
        else:
            state = state_of(told.message)
            inputs.append(Input(state.revision, state.first_step, state.scenario))
    bag = Bag(source.path, losses.append)
    if total.first is None:  # nobody recorded summaries
        for piece in _pieces(bag):
            total.add(piece)
    first = total.first
    return Overview(
        path=source.path,
        files={file.name: file.stat().st_size for file in source.files},
        info=bag.info,
        start_ns=start_ns,
        topics={topic: TopicCount(types[topic], counts[topic]) for topic in sorted(counts)},
        first_step=first.first_step if first else 0,
        steps=total.steps,
        start=first.time if first else 0.0,
        duration=total.duration,
        summary=total.summary,
        revisions=revisions([*bag.info.inputs, *inputs]),
        impacts=(impacts[0], impacts[1]),
        losses=tuple(dict.fromkeys(losses)),  # a bag that is gone through twice tells some twice
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
