"""Read the messages of a bag, file after file, and report everything that is wrong with the files.

All readers of bags are built on this one: ``Bag`` (blocks and arrays), ``overview``, ``recover`` and playback.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Metadata
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError

from ..errors import NoBagError, RecordingError
from .definitions import DefinitionError, decoder
from .folder_metadata import missing_files
from .losses import Damage, Loss
from .mcap.reader import UNREADABLE, Chunk, McapReader, StoredMessage
from .run_info import RunInfo
from .window import EVERYTHING, RunWindow, first_chunk

DAMAGE = (*UNREADABLE, SerdeError, TypesysError)
FORCES = "ContactForces"
Lost = Callable[[Loss], object]


class Located(NamedTuple):
    """A stored message with the chunk and the file that hold it."""

    message: StoredMessage
    chunk: Chunk
    mcap: McapReader


@dataclass(frozen=True)
class BagReader:
    """Messages of a bag, a file or a folder.

    All damage is left out and reported to ``lost``; without it, damage raises RecordingError.
    """

    path: Path
    lost: Lost | None = None

    @cached_property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order; raises NoBagError if there are none."""
        path = self.path
        if not path.exists():
            raise NoBagError(f"{path} does not exist: give a bag folder or an .mcap file")
        if path.is_file():
            return (path,)
        files = sorted(path.glob("*.mcap"), key=lambda file: (_number(file.name), file.name))
        if not files:
            inside = min((file.parent for file in path.glob("*/*.mcap")), default=None)  # of snapshots, of recordings
            such = f", such as {inside}" if inside else ""
            raise NoBagError(f"{path} holds no .mcap file: give a bag folder or an .mcap file{such}")
        return tuple(files)

    @property
    def quiet(self) -> BagReader:
        """The same without reports of damage, for preliminary look-ups."""
        return BagReader(self.path, self.lost and _ignore)

    @cached_property
    def info(self) -> RunInfo | None:
        """The record of the run in the first file that has one; None if there is none."""
        for file in self.files:
            for _, item in self.quiet.contents(file):
                if isinstance(item, Chunk):
                    break
                if info := self.info_in(file, item):
                    return info
        return None

    def info_in(self, file: Path, record: Metadata) -> RunInfo | None:
        """The run that a record of metadata in ``file`` describes; None if it is about something else, or damaged."""
        try:
            return RunInfo.among(record.name, record.metadata)
        except ValueError as reason:
            self._damaged(file, Damage(file.name, 0, 0, str(reason)))
            return None

    def topics(self, kind: str) -> list[str]:
        """Topics of a short type, in the order of their numbers in the first file that has samples."""
        for file in self.files:
            with self.opened(file) as mcap:
                if mcap.index is None:
                    _look_for_topics(mcap)
                kinds = {topic.name: topic.kind for topic in mcap.topics}
                found = [name for name, of in kinds.items() if of == kind]
                if found or FORCES in kinds.values():
                    return found
        return []

    def messages(self, kinds: Sequence[str]) -> Iterator[Any]:
        """Messages of some short types in the order of the files, decoded."""
        for found in self.stored(kinds):
            if found.message.topic.kind in kinds:
                message = self.decoded(found)
                if message is not None:
                    yield message

    def stored(self, kinds: Sequence[str], window: RunWindow = EVERYTHING) -> Iterator[Located]:
        """All messages of chunks that may hold some of ``kinds`` in the window; every message if samples are wanted.

        Raises RecordingError for a bag of several runs, whose messages differ by nothing but their topics.
        """
        runs = [*self.quiet.topics(FORCES)]
        self._require_one(runs)
        for mcap, chunk in self._chunks(window, kinds):
            for message in mcap.messages(chunk):
                topic = message.topic
                if topic.kind == FORCES and topic.name not in runs:
                    runs.append(topic.name)
                    self._require_one(runs)
                yield Located(message, chunk, mcap)

    def decoded(self, found: Located) -> Any:
        """A message of this package with its fields as attributes; None if it does not match its definition."""
        (topic, *_, data), chunk, mcap = found
        try:
            return decoder(topic.kind, topic.encoding, topic.definition)(data)
        except DefinitionError as reason:
            raise self._refusal(reason) from None
        except DAMAGE as reason:
            mcap.report(chunk.place, chunk.end, f"a {topic.kind}: {_one_line(reason)}")
            return None

    def contents(self, file: Path) -> Iterator[tuple[McapReader, Chunk | Metadata]]:
        """All readable parts of a file."""
        with self.opened(file) as mcap:
            for item in mcap.scan():
                yield mcap, item

    @contextmanager
    def opened(self, file: Path) -> Iterator[McapReader]:
        """One file; everything that can be wrong with it raises RecordingError in one line."""
        try:
            with file.open("rb") as stream:
                mcap = McapReader(stream, file.name, lambda damage: self._damaged(file, damage))
                if self.lost is None and mcap.index is None:
                    raise _incomplete(file, "it has no index")
                yield mcap
        except OSError as reason:
            raise RecordingError(
                f"{file} cannot be read ({reason.strerror}): give a bag folder or an .mcap file"
            ) from None
        except DAMAGE as reason:
            raise _incomplete(file, _one_line(reason)) from reason

    def report_missing(self) -> None:
        """Report missing files; without ``lost``, missing samples raise RecordingError."""
        for damage in missing_files(self.path) if self.path.is_dir() else ():
            if self.lost:
                self.lost(damage)
            elif damage.file.endswith(".mcap"):
                raise RecordingError(f"{self.path}: {damage.file} is missing, which metadata.yaml names: put it back")

    def _chunks(self, window: RunWindow, kinds: Sequence[str]) -> Iterator[tuple[McapReader, Chunk]]:
        """Chunks that may hold messages of some types in a window; those of all samples in the order of the files."""
        places = None if window.whole and FORCES in kinds else self._places(kinds)
        if places is None:
            for file in self.files:
                for mcap, item in self.contents(file):
                    if isinstance(item, Chunk):
                        yield mcap, item
            return
        first = 0
        if not window.whole:
            first = max(0, first_chunk(len(places), window, lambda number: self._first_sample(*places[number])) - 1)
        for file, group in groupby(places[first:], key=lambda place: place[0]):
            with self.opened(file) as mcap:
                for chunk in mcap.chunks_at(place for _, place in group):
                    yield mcap, chunk

    def _places(self, kinds: Sequence[str]) -> list[tuple[Path, int]] | None:
        """Files and places of the chunks that may hold messages of some types; None if a file has no index."""
        found: list[tuple[Path, int]] = []
        for file in self.files:
            with self.opened(file) as mcap:
                if mcap.index is None:
                    return None
                wanted = {topic.name for topic in mcap.topics if topic.kind in kinds}
                found += [(file, span.place) for span in mcap.spans() if wanted & span.topics]
        return found

    def _first_sample(self, file: Path, place: int) -> tuple[int, float] | None:
        """Step and time of the first contact forces in a chunk."""
        with BagReader(self.path, _ignore).opened(file) as mcap:
            for chunk in mcap.chunks_at([place]):
                for message in mcap.messages(chunk):
                    topic = message.topic
                    if topic.kind == FORCES:
                        forces = decoder(FORCES, topic.encoding, topic.definition)(message.data)
                        return int(forces.first_step), float(forces.time)
        return None

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


def beside(path: Path, ending: str) -> Path:
    """A path beside a bag: with ``.html``, ``run.html`` for ``run.mcap`` and ``run.1.html`` for a folder ``run.1``.

    For ``.``, it has the name of the current folder.
    """
    path = path if path.name not in ("", "..") else path.resolve()
    return path.with_name(f"{path.name.removesuffix('.mcap')}{ending}")


def _number(name: str) -> int:
    """Number at the end of a file's name."""
    found = re.search(r"(\d+)\.mcap$", name)
    return int(found[1]) if found else 0


def _one_line(reason: BaseException) -> str:
    """Message of an error of a library."""
    return " ".join(str(reason).split()) or type(reason).__name__


def _look_for_topics(mcap: McapReader) -> None:
    """Read the beginning of a file without index: topics are defined when their first message comes."""
    forces = 0
    for item in mcap.scan():
        if isinstance(item, Chunk):
            forces += sum(message.topic.kind == FORCES for message in mcap.messages(item))
            if forces > 2:
                return


def _ignore(loss: Loss) -> None:
    """Report nothing."""


def _incomplete(file: Path, what: str) -> RecordingError:
    return RecordingError(
        f"{file} is not a complete bag ({what}): it is damaged, was not closed, or is another kind of file"
    )
