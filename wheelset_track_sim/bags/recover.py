"""A bag that all tools open, made of what can be read of a damaged one, which stays as it is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mcap.records import Metadata

from ..errors import RecordingError
from .bag import Bag
from .bag_copy import BagCopy
from .files import beside, files_of, missing_files
from .losses import Damage, Gap, Loss
from .mcap.records import Message
from .mcap.source import McapSource
from .run_info import RunInfo


@dataclass(frozen=True)
class Recovered:
    """What a recovered bag holds, and what it does not."""

    path: Path
    chunks: int
    """Chunks that were saved."""
    chunks_lost: int
    """Chunks that are named by the indexes and were not saved; of a file without index, the stretches between chunks
    that cannot be read."""
    messages: int
    first_step: int
    """Of the samples that were saved."""
    steps: int
    """Steps whose forces and stresses are all there."""
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
    """Write all messages of a bag that stand in whole chunks into a new one, ``out``, and read that back.

    ``out`` is one file if it ends in ``.mcap``, otherwise a folder with ``metadata.yaml`` and a file for each one that
    holds something; without it, a folder beside the bag whose name ends in ``_recovered``. Messages keep their bytes,
    definitions, topics and times, chunks their bounds.

    Raises InputError if ``out`` exists, RecordingError if it cannot be written or there is nothing to be saved; nothing
    is left behind then.
    """
    source = Path(path)
    files = files_of(source)
    copy = BagCopy(Path(out) if out is not None else beside(source, "_recovered"))
    losses: list[Loss] = [*missing_files(source)]
    lost = 0
    try:
        for file in files:
            copy.begin()
            with file.open("rb") as stream:
                lost += _take(McapSource(stream, file.name), copy, losses)
        copy.finish()
        if copy.messages == 0:
            raise RecordingError(  # noqa: TRY301 - as for all others, nothing is left behind
                f"{source} holds nothing that can be saved ({losses[0] if losses else 'it has no messages'}): "
                "give a bag with a whole chunk"
            )
    except BaseException as reason:
        copy.remove()
        if isinstance(reason, OSError):
            raise RecordingError(
                f"{source} cannot be saved to {copy.path} ({reason.strerror}): free space or give another path"
            ) from None
        raise
    first, steps, seconds = _read_back(copy.path, losses)
    return Recovered(copy.path, copy.chunks, lost, copy.messages, first, steps, seconds, tuple(losses))


def _take(source: McapSource, copy: BagCopy, losses: list[Loss]) -> int:
    """Copy what can be read of a file; returns how many chunks of it cannot, as far as that is known."""
    info: Metadata | None = None
    saved, stretches = copy.chunks, 0
    for item in source.scan():
        if isinstance(item, Damage):
            losses.append(item)
            stretches += source.index is None and item.place < item.end < source.size
        elif isinstance(item, Metadata):
            try:
                info = item if RunInfo.among(item.name, item.metadata) else info
            except ValueError as reason:
                losses.append(Damage(source.name, 0, 0, str(reason)))
        else:
            told = source.messages(item)
            losses += [one for one in told if isinstance(one, Damage)]
            if messages := [one for one in told if isinstance(one, Message)]:
                copy.write(messages, info)
    return len(source.index.chunks) - (copy.chunks - saved) if source.index else stretches


def _read_back(path: Path, losses: list[Loss]) -> tuple[int, int, float]:
    """First step, steps and seconds that the new bag holds; gaps between them are added to what is lost."""
    first, steps, seconds = 0, 0, 0.0
    try:
        for block in Bag(path, losses.append).blocks():
            first = first if steps else block.first_step
            steps += len(block)
            seconds += len(block) * block.step_period
    except RecordingError as reason:  # other messages than those of a run are worth saving, too
        losses.append(Damage(path.name, 0, 0, str(reason)))
    return first, steps, seconds
