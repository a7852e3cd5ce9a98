"""Recover a damaged bag: write everything readable into a new bag that all tools open."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Metadata

from ..errors import InputError, RecordingError
from .bag import Bag
from .bag_file import BagFile
from .bag_reader import BagReader, beside
from .folder_metadata import METADATA, BagPart, write_folder_metadata
from .losses import Damage, Gap, Loss
from .mcap.reader import StoredMessage
from .topics import Topic


@dataclass(frozen=True)
class Recovered:
    """A recovered bag: what it holds, and what is lost."""

    path: Path
    chunks: int
    """Chunks that were saved."""
    chunks_lost: int
    """Chunks that the indexes list and that were not saved; for a file without index, the unreadable stretches between
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
    copy = _Copy(Path(out) if out is not None else beside(reader.path, "_recovered"))
    reader.report_missing()
    lost = 0
    try:
        for file in files:
            lost += _take(reader, file, copy, losses)
        copy.finish()
        if copy.messages == 0:
            raise RecordingError(  # noqa: TRY301 - as for all others, nothing is left behind
                f"{reader.path} holds nothing that can be saved ({losses[0] if losses else 'it has no messages'}): "
                "give a bag with a whole chunk"
            )
    except BaseException as reason:
        copy.remove()
        if isinstance(reason, OSError):
            raise RecordingError(
                f"{reader.path} cannot be saved to {copy.path} ({reason.strerror}): free space or give another path"
            ) from None
        raise
    first, steps, seconds = _read_back(copy.path, losses)
    return Recovered(copy.path, copy.chunks, lost, copy.messages, first, steps, seconds, tuple(losses))


def _take(reader: BagReader, file: Path, copy: _Copy, losses: list[Loss]) -> int:
    """Copy the readable chunks of a file; returns how many others there are, as far as that is known."""
    copy.end_file()
    with reader.opened(file) as mcap:
        listed = None if mcap.index is None else len(mcap.index.chunks)
    info: Metadata | None = None
    before, saved = len(losses), copy.chunks
    read: set[int] = set()
    for mcap, item in reader.contents(file):
        if isinstance(item, Metadata):
            info = item if reader.info_in(file, item) else info
            continue
        read.add(item.place)
        if messages := [*mcap.messages(item)]:
            copy.write(messages, info)
    if listed is not None:
        return listed - (copy.chunks - saved)
    damages = [loss for loss in losses[before:] if isinstance(loss, Damage) and loss.place not in read]
    return sum(damage.place < damage.end < mcap.size for damage in damages)


class _Copy:
    """Messages as they are, in one file if its path ends in ``.mcap``, otherwise in a folder."""

    def __init__(self, path: Path) -> None:
        """Write nothing before the first chunk; raises InputError if the path exists."""
        if path.exists():
            raise InputError(f"{path} exists already: give another path, or remove it first")
        self.path = path
        self.chunks = self.messages = 0
        self._folder = path.suffix != ".mcap"
        self._made: list[Path] = []
        self._file: BagFile | None = None
        self._parts: list[BagPart] = []
        self._topics: dict[str, Topic] = {}

    def write(self, messages: Iterable[StoredMessage], info: Metadata | None) -> None:
        """Write messages as one chunk, with the record ``info`` where a file begins."""
        file = self._file = self._file or self._new_file(info)
        for message in messages:
            times = message.log_time, message.publish_time
            file.add(message.topic, times[0], message.data, sequence=message.sequence, published_ns=times[1])
            self._topics.setdefault(message.topic.name, message.topic)
            self.messages += 1
        file.flush()
        self.chunks += 1

    def end_file(self) -> None:
        """Continue in another file, if the path is a folder."""
        if self._folder:
            self._finish_file()

    def finish(self) -> None:
        """Finish the bag."""
        self._finish_file()
        if self._folder and self._parts:
            self._made.append(self.path / METADATA)
            write_folder_metadata(self.path, self._parts, [*self._topics.values()])

    def remove(self) -> None:
        """Remove everything that was written."""
        if self._file is not None:
            self._file.abandon()
        for path in reversed(self._made):
            path.rmdir() if path.is_dir() else path.unlink(missing_ok=True)

    def _new_file(self, info: Metadata | None) -> BagFile:
        if not self._parts:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            if self._folder:
                self.path.mkdir()
                self._made.append(self.path)
        path = self.path / f"{self.path.name}_{len(self._parts)}.mcap" if self._folder else self.path
        file = BagFile(path, 0, {info.name: info.metadata} if info else {})
        self._made.append(path)
        return file

    def _finish_file(self) -> None:
        if self._file is not None:
            self._file.finish()
            self._parts.append(self._file.part)
            self._file = None


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
