"""The messages of a bag, file after file, with all that can be wrong with the files named."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Metadata, Schema
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError

from ..errors import RecordingError
from .definitions import PACKAGE
from .files import files_of, missing_files
from .losses import Damage, Loss
from .mcap.records import UNREADABLE, Chunk, Message
from .mcap.source import McapSource
from .run_info import RunInfo
from .stored_types import DefinitionError, reader
from .window import EVERYTHING, Window, first_chunk

DAMAGE = (*UNREADABLE, SerdeError, TypesysError)
FORCES = "ContactForces"
Lost = Callable[[Loss], object]


class Stored(NamedTuple):
    """A message as it is stored, and where."""

    file: Path
    chunk: Chunk
    message: Message


class Told(NamedTuple):
    """A message of this package."""

    kind: str
    """Short type name."""
    topic: str
    message: Any


@dataclass(frozen=True)
class BagSource:
    """Messages of a bag, a file or a folder; those of this package, found by their types.

    ``lost`` is told of all that is damaged, which is left out then; without it, damage raises RecordingError.
    """

    path: Path
    lost: Lost | None = None

    @cached_property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order."""
        return files_of(self.path)

    @property
    def quiet(self) -> BagSource:
        """The same, which tells nobody what is damaged, for what is looked up on the way."""
        return BagSource(self.path, self.lost and _unheard)

    @cached_property
    def info(self) -> RunInfo | None:
        """What the first file that says something says about its run; None if none does."""
        for file in self.files:
            for _, item in self.quiet.contents(file):
                if isinstance(item, Chunk):
                    break
                try:
                    if info := RunInfo.among(item.name, item.metadata):
                        return info
                except ValueError as reason:
                    self._damaged(file, Damage(file.name, 0, 0, str(reason)))
        return None

    def topics(self, kind: str) -> list[str]:
        """Topics of a short type, in the order of their numbers in the first file that has samples."""
        for file in self.files:
            with self._reading(file) as source:
                if source.index is None:
                    _look_for_topics(source)
                kinds = {channel.topic: kind_of(schema) for channel, schema in source.topics()}
                found = [topic for topic, name in kinds.items() if name == kind]
                if found or FORCES in kinds.values():
                    return found
        return []

    def messages(
        self, kinds: Sequence[str], window: Window = EVERYTHING, wanted: Callable[[str, str], bool] | None = None
    ) -> Iterator[Told]:
        """Messages of some short types in the order of the files: all that may be in the window, and others.

        ``wanted`` says by type and topic which are read at all.
        """
        for stored in self.stored(kinds, window):
            kind = kind_of(stored.message.schema)
            if kind in kinds and (wanted is None or wanted(kind, stored.message.channel.topic)):
                told = self.told(stored)
                if told is not None:
                    yield told

    def stored(self, kinds: Sequence[str], window: Window = EVERYTHING) -> Iterator[Stored]:
        """All messages of chunks that may hold some of ``kinds`` in the window; every message if samples are wanted.

        Raises RecordingError for a bag of several runs: nothing but its topic tells whose a message is.
        """
        runs = [*self.quiet.topics(FORCES)]
        self._require_one(runs)
        for file, source, chunk in self._chunks(window, kinds):
            for item in source.messages(chunk):
                if isinstance(item, Damage):
                    self._damaged(file, item)
                    continue
                if item.channel.topic not in runs and kind_of(item.schema) == FORCES:
                    runs.append(item.channel.topic)
                    self._require_one(runs)
                yield Stored(file, chunk, item)

    def told(self, stored: Stored) -> Told | None:
        """What a message of this package tells; None if it is not what its definition says, which is damage."""
        file, chunk, message = stored
        kind = kind_of(message.schema)
        try:
            return Told(kind, message.channel.topic, reader(kind, message.schema)(message.data))
        except DefinitionError as reason:
            raise self._refusal(reason) from None
        except DAMAGE as reason:
            self._damaged(file, Damage(file.name, chunk.place, chunk.end, f"a {kind}: {one_line(reason)}"))
            return None

    def contents(self, file: Path) -> Iterator[tuple[McapSource, Chunk | Metadata]]:
        """All of a file that can be read."""
        with self._reading(file) as source:
            for item in source.scan():
                if isinstance(item, Damage):
                    self._damaged(file, item)
                else:
                    yield source, item

    def tell_missing(self) -> None:
        """Tell which files are missing; RecordingError if nobody is there to be told, and samples are missing."""
        for damage in missing_files(self.path):
            if self.lost:
                self.lost(damage)
            elif damage.file.endswith(".mcap"):
                raise RecordingError(f"{self.path}: {damage.file} is missing, which metadata.yaml names: put it back")

    def _chunks(self, window: Window, kinds: Sequence[str]) -> Iterator[tuple[Path, McapSource, Chunk]]:
        """Chunks that may hold messages of some types in a window; all that holds samples is gone through in order."""
        places = None if window.whole and FORCES in kinds else self._places(kinds)
        if places is None:
            for file in self.files:
                for source, item in self.contents(file):
                    if isinstance(item, Chunk):
                        yield file, source, item
            return
        first = 0
        if not window.whole:
            first = max(0, first_chunk(len(places), window, lambda number: self._first_sample(*places[number])) - 1)
        for file, group in groupby(places[first:], key=lambda place: place[0]):
            with self._reading(file) as source:
                for chunk in source.chunks_at(place for _, place in group):
                    if isinstance(chunk, Damage):
                        self._damaged(file, chunk)
                    else:
                        yield file, source, chunk

    def _places(self, kinds: Sequence[str]) -> list[tuple[Path, int]] | None:
        """Files and places of the chunks that may hold messages of some types; None if not all files have an index."""
        found: list[tuple[Path, int]] = []
        for file in self.files:
            with self._reading(file) as source:
                if source.index is None:
                    return None
                wanted = {channel.id for channel, schema in source.topics() if kind_of(schema) in kinds}
                found += [
                    (file, chunk.chunk_start_offset)
                    for chunk in sorted(source.index.chunks, key=lambda chunk: chunk.chunk_start_offset)
                    if not chunk.message_index_offsets or wanted & chunk.message_index_offsets.keys()
                ]
        return found

    def _first_sample(self, file: Path, place: int) -> tuple[int, float] | None:
        """Step and time of the first contact forces in a chunk."""
        with self._reading(file) as source:
            for chunk in source.chunks_at([place]):
                for item in source.messages(chunk) if isinstance(chunk, Chunk) else ():
                    if isinstance(item, Message) and kind_of(item.schema) == FORCES:
                        message = reader(FORCES, item.schema)(item.data)
                        return int(message.first_step), float(message.time)
        return None

    @contextmanager
    def _reading(self, file: Path) -> Iterator[McapSource]:
        """One file, with all that can be wrong with it as one line."""
        try:
            with file.open("rb") as stream:
                source = McapSource(stream, file.name)
                if self.lost is None and source.index is None:
                    raise _incomplete(file, "it has no index")
                yield source
        except OSError as reason:
            raise RecordingError(
                f"{file} cannot be read ({reason.strerror}): give a bag folder or an .mcap file"
            ) from None
        except DAMAGE as reason:
            raise _incomplete(file, one_line(reason)) from reason

    def _require_one(self, runs: Sequence[str]) -> None:
        if len(runs) > 1:
            raise RecordingError(
                f"{self.path} holds {len(runs)} runs ({', '.join(runs)}): record each into a bag of its own, or take "
                "one out by its topics with ros2 bag convert"
            )

    def _damaged(self, file: Path, damage: Damage) -> None:
        if self.lost is None:
            raise _incomplete(file, damage.what)
        self.lost(damage)

    def _refusal(self, reason: DefinitionError) -> RecordingError:
        version = self.info.versions.get("wheelset_track_sim") if self.info else None
        return RecordingError(
            f"{self.path} was recorded by wheelset_track_sim {version or 'of an unknown version'}, whose {reason}: "
            "read it with that version"
        )


def kind_of(schema: Schema) -> str:
    """Short type name of a message of this package; empty for others."""
    package, _, kind = schema.name.partition("/msg/")
    return kind if package == PACKAGE else ""


def one_line(reason: BaseException) -> str:
    """What an error of a library says."""
    return " ".join(str(reason).split()) or type(reason).__name__


def _look_for_topics(source: McapSource) -> None:
    """Read the beginning of a file without index: topics are defined when their first message comes."""
    forces = 0
    for item in source.scan():
        if isinstance(item, Chunk):
            found = source.messages(item)
            forces += sum(isinstance(one, Message) and kind_of(one.schema) == FORCES for one in found)
            if forces > 2:
                return


def _unheard(loss: Loss) -> None:
    """Nobody is told."""


def _incomplete(file: Path, what: str) -> RecordingError:
    return RecordingError(
        f"{file} is not a complete bag ({what}): it is damaged, was not closed, or is another kind of file"
    )
