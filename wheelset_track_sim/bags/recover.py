"""Recover a damaged bag: write everything readable into a new bag that all tools open."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mcap.records import Metadata

from ..errors import InputError, RecordingError
from .bag import Bag
from .bag_file import BagFiles
from .bag_reader import BagReader, beside
from .losses import Damage, Gap, Loss


@dataclass(frozen=True)
class Recovered:
    """A recovered bag: what it holds, and what is lost."""

    path: Path
    chunks: int
    """Chunks that were saved."""
    chunks_lost: int
    """Chunks of the files that were not saved; for a file without index, the unreadable stretches between
    chunks."""
    messages: int
    first_step: int
    """Of the samples that were saved."""
    steps: int
    """Steps with all forces and stresses."""
    seconds: float
    """Simulated time of these."""
    losses: tuple[Loss, ...]

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Steps that are missing in between."""
        return tuple(loss for loss in self.losses if isinstance(loss, Gap))

    @property
    def bytes_lost(self) -> int:
        """Bytes of the files that cannot be read."""
        return sum(loss.end - loss.place for loss in self.losses if isinstance(loss, Damage))


def recover(path: str | Path, out: str | Path | None = None) -> Recovered:
    """Write all messages in undamaged chunks of a bag into a new one, ``out``, and read that back.

    ``out`` is one file if it ends in ``.mcap``, otherwise a folder with ``metadata.yaml`` and a file for each one that
    holds something; without it, a folder beside the bag whose name ends in ``_recovered``. Messages keep their bytes,
    definitions, topics and times, chunks their bounds. The damaged bag is not changed.

    Raises InputError if ``out`` exists, RecordingError if it cannot be written or nothing can be saved; nothing is left
    behind then.
    """
    losses: list[Loss] = []
    reader = BagReader(Path(path), losses.append)
    files = reader.files
    target = Path(out) if out is not None else beside(reader.path, "_recovered")
    if target.exists():
        raise InputError(f"{target} exists already: give another path, or remove it first")
    reader.report_missing()
    try:
        copy = BagFiles(target)
        try:
            counts = [_copy(reader, file, copy, losses) for file in files]
            copy.finish()
            messages = sum(part.count for part in copy.finished)
            if messages == 0:
                raise RecordingError(  # noqa: TRY301 - as for all others, nothing is left behind
                    f"{reader.path} holds nothing that can be saved ({losses[0] if losses else 'it has no messages'}): "
                    "give a bag with a whole chunk"
                )
        except BaseException:
            copy.remove()
            raise
    except OSError as reason:
        raise RecordingError(
            f"{reader.path} cannot be saved to {target} ({reason.strerror}): free space or give another path"
        ) from None
    saved, lost = (sum(of) for of in zip(*counts, strict=True))
    first, steps, seconds = _read_back(target, losses)
    return Recovered(target, saved, lost, messages, first, steps, seconds, tuple(dict.fromkeys(losses)))


def _copy(reader: BagReader, file: Path, copy: BagFiles, losses: list[Loss]) -> tuple[int, int]:
    """Copy the readable chunks of a file; returns their number, and the number of others as far as that is known."""
    with reader.opened(file) as mcap:
        listed = len(mcap.layout.parts) if mcap.layout else None
    out = None if copy.folder else copy.current
    info: dict[str, dict[str, str]] = {}
    saved, before = 0, len(losses)
    read: set[int] = set()
    for mcap, item in reader.contents(file):
        if isinstance(item, Metadata):
            info = {item.name: item.metadata} if reader.info_in(file, item) else info
            continue
        read.add(item.place)
        some = False
        for topic, sequence, time_ns, published_ns, data in mcap.messages(item):
            out, some = out or copy.begin(0, info), True
            out.add(topic, time_ns, data, sequence=sequence, published_ns=published_ns)
        if out is not None and some:
            out.flush()
            saved += 1
    if listed is not None:
        return saved, max(0, listed - saved)
    damages = [loss for loss in losses[before:] if isinstance(loss, Damage) and loss.place not in read]
    return saved, sum(damage.place < damage.end < mcap.size for damage in damages)


def _read_back(path: Path, losses: list[Loss]) -> tuple[int, int, float]:
    """First step, steps and seconds in the new bag; gaps between them are added to the losses."""
    first, steps, seconds = 0, 0, 0.0
    try:
        for block in Bag(path, losses.append).blocks():
            first = first if steps else block.first_step
            steps += len(block)
            seconds += len(block) * block.step_period
    except RecordingError as reason:  # messages that are not of a run are worth saving, too
        losses.append(Damage(path.name, 0, 0, str(reason)))
    return first, steps, seconds
