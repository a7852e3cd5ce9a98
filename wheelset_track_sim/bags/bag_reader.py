"""Read the messages of a bag, file after file, and report everything that is wrong with the files.

All readers of bags are built on this one: ``Bag`` (blocks and arrays), ``overview``, ``recover`` and playback.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby, takewhile
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, TypeVar

from mcap.records import Metadata
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError

from ..errors import NoBagError, RecordingError
from .definitions import DefinitionError, decoder
from .folder_files import FolderFiles, folder_files, suffix_of
from .folder_metadata import METADATA
from .losses import Damage, Loss
from .mcap.reader import UNREADABLE, Chunk, Known, McapReader, StoredMessage
from .messages import start_of
from .run_info import RunInfo
from .stored_files import StoredFiles, is_bag
from .window import EVERYTHING, RunWindow, first_chunk

T = TypeVar("T")
DAMAGE = (*UNREADABLE, SerdeError, TypesysError, ArithmeticError, TypeError, AttributeError)
"""Errors of the libraries, and of our own functions, for content that is not what it should be."""
FORCES, STRESS = "ContactForces", "AxleStress"
SAMPLES = (FORCES, STRESS)
LONGEST_REASON = 300
"""Characters of a library's message that are shown."""
SAME_START = 1000
"""Difference in the time of step 0, ns, within one run: rounding."""
Lost = Callable[[Loss], object]


class Located(NamedTuple):
    """A stored message with the chunk and the file that hold it."""

    message: StoredMessage
    chunk: Chunk
    mcap: McapReader


class _Place(NamedTuple):
    """Where messages are."""

    file: Path
    place: int
    first_ns: int
    last_ns: int


class _Order(NamedTuple):
    """What the files of a bag say of their topics."""

    kinds: dict[str, str]
    """Short type of each topic."""
    disordered: bool


@dataclass(frozen=True)
class BagReader:
    """Messages of a bag, a file or a folder.

    All damage is left out and reported to ``lost``; without it, damage raises RecordingError.
    """

    path: Path
    lost: Lost | None = None

    _known: dict[Path, Known] = field(default_factory=dict, compare=False, repr=False)
    _stored: StoredFiles = field(default_factory=StoredFiles, compare=False, repr=False)

    @property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order; raises NoBagError if there are none."""
        return self.folder.files

    @cached_property
    def folder(self) -> FolderFiles:
        """The files of the bag, and what is wrong with their list; raises NoBagError if there are none."""
        path = self.path
        if not path.exists():
            raise NoBagError(f"{path} does not exist: give a bag folder or an .mcap file")
        if path.is_file():
            with self.quiet._stream(path) as stream:
                if not is_bag(stream):
                    raise NoBagError(f"{path} is neither MCAP nor SQLite: give a bag folder, or an .mcap or .db3 file")
            return FolderFiles((path,))
        if not path.is_dir():
            raise NoBagError(f"{path} is a device or a pipe: give a bag folder or an .mcap file")
        found = folder_files(path, self.quiet.begins)
        if not found.files:
            inside = min((file.parent for file in path.glob("*/*.mcap")), default=None)  # of snapshots, of recordings
            such = f", such as {inside}" if inside else ""
            raise NoBagError(f"{path} holds no .mcap or .db3 file: give a bag folder or an .mcap file{such}")
        return found

    @property
    def quiet(self) -> BagReader:
        """The same without reports of damage, for preliminary look-ups."""
        return BagReader(self.path, self.lost and _ignore, self._known, self._stored)

    @cached_property
    def info(self) -> RunInfo | None:
        """The record of the run in the first file that has one; None if there is none."""
        for file in self.files:
            with self.quiet.opened(file) as mcap:
                at_start = [*takewhile(lambda item: isinstance(item, Metadata), mcap.scan())]
                for item in (*at_start, *(item for item in mcap.metadata() if item not in at_start)):
                    if isinstance(item, Metadata) and (info := self.info_in(file, item)):
                        return info
        return None

    def begins(self, file: Path) -> int | None:
        """Time of the first message of a file, ns; None if none can be read."""
        with BagReader(file, _ignore, self._known, self._stored).opened(file) as mcap:
            if mcap.layout is not None:
                return min((part.first_ns for part in mcap.layout.parts), default=None)
            for span in mcap.spans():
                return span.first_ns
        return None

    def info_in(self, file: Path, record: Metadata) -> RunInfo | None:
        """The run that a record of metadata in ``file`` describes; None if it is about something else, or damaged."""
        try:
            return RunInfo.among(record.name, record.metadata)
        except ValueError as reason:
            self._damaged(file, Damage(file.name, 0, 0, str(reason)))
            return None

    def topics(self, kind: str) -> list[str]:
        """Topics of a short type, in the order of their numbers in the first file that has them."""
        return [name for name, of in self._order.kinds.items() if of == kind]

    @property
    def disordered(self) -> bool:
        """Whether samples are known to be stored in another order than that of time."""
        return self._order.disordered

    @cached_property
    def _order(self) -> _Order:
        """Topics, and whether their messages are in the order of time; files that do not list them are read for it."""
        kinds: dict[str, str] = {}
        disordered = False
        for file in self.files:
            with self.quiet.opened(file) as mcap:
                if not mcap.lists_all:
                    deque(mcap.look_through(), maxlen=0)
                for topic in mcap.topics:
                    kinds.setdefault(topic.name, topic.kind)
                disordered = disordered or any(kinds.get(name) in SAMPLES for name in mcap.unordered)
        return _Order(kinds, disordered)

    def messages(self, kinds: Sequence[str], make: Callable[[Any], T]) -> Iterator[T]:
        """What ``make`` makes of each message of some short types, in the order of the files."""
        for found in self.stored(kinds):
            if found.message.topic.kind in kinds:
                message = self.decoded(found)
                made = None if message is None else self.made(found, partial(make, message))
                if made is not None:
                    yield made

    def stored(self, kinds: Sequence[str], window: RunWindow = EVERYTHING) -> Iterator[Located]:
        """All messages of chunks that may hold some of ``kinds`` in the window; every message if samples are wanted.

        Raises RecordingError for a bag of several runs, whose messages differ by nothing but their topics.
        """
        runs = [*self.topics(FORCES)]
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
        topic, data = found.message.topic, found.message.data
        return self.made(found, lambda: decoder(topic.kind, topic.encoding, topic.definition)(data))

    def made(self, found: Located, make: Callable[[], T]) -> T | None:
        """What ``make`` makes of a message; None if its content cannot be used, which is reported as damage.

        Everything that is made of the content of bags is made within, so that no content raises anything else.
        """
        try:
            return make()
        except DefinitionError as reason:
            raise self._refusal(reason) from None
        except DAMAGE as reason:
            found.mcap.report(found.chunk.place, found.chunk.end, f"a {found.message.topic.kind}: {_one_line(reason)}")
            return None

    def contents(self, file: Path) -> Iterator[tuple[McapReader, Chunk | Metadata]]:
        """All readable parts of a file."""
        with self.opened(file) as mcap:
            for item in mcap.scan():
                yield mcap, item

    @contextmanager
    def opened(self, file: Path) -> Iterator[McapReader]:
        """One file; everything that can be wrong with it raises RecordingError in one line."""
        with self._stream(file) as stream:
            mcap = McapReader(stream, file.name, lambda damage: self._damaged(file, damage), self._known.get(file))
            self._known[file] = mcap.known
            if self.lost is None and mcap.index is None:
                raise _incomplete(file, "it was not closed" if mcap.size else "it is empty")
            yield mcap

    @contextmanager
    def _stream(self, file: Path) -> Iterator[BinaryIO]:
        """A file as MCAP; errors as in ``opened``."""
        try:
            with self._stored.opened(file, lambda why: self._damaged(file, Damage(file.name, 0, 0, why))) as stream:
                yield stream
        except NoBagError:
            raise
        except OSError as reason:
            raise RecordingError(
                f"{file} cannot be read ({reason.strerror}): give a bag folder or an .mcap file"
            ) from None
        except DAMAGE as reason:
            raise _incomplete(file, _one_line(reason)) from reason

    def report_missing(self) -> None:
        """Report missing files; without ``lost``, missing samples raise RecordingError."""
        for damage in self.folder.damages:
            if self.lost:
                self.lost(damage)
            elif damage.file != METADATA:
                raise RecordingError(f"{self.path}: {damage.file}, which metadata.yaml names: {damage.reason}")

    def _chunks(self, window: RunWindow, kinds: Sequence[str]) -> Iterator[tuple[McapReader, Chunk]]:
        """Chunks that may hold messages of some types in a window; those of all samples in the order of the files."""
        everything = window.whole and FORCES in kinds
        places = None if everything else self._places(kinds)
        if places is None:
            for file in self.files:
                yield from self._all_chunks(file)
            return
        first = 0 if window.whole else self._first_place(places, window)
        for file, group in groupby(places[first:], key=lambda place: place.file):
            with self.opened(file) as mcap:
                for chunk in mcap.chunks_at(place.place for place in group):
                    yield mcap, chunk

    def _all_chunks(self, file: Path) -> Iterator[tuple[McapReader, Chunk]]:
        """All chunks of a file, in the order of time if its topics are stored apart."""
        with self.opened(file) as mcap:
            layout = mcap.layout
            if layout is None or layout.in_time is layout.parts:
                for item in mcap.scan():
                    if isinstance(item, Chunk):
                        yield mcap, item
                return
            if not mcap.lists_all:  # in another order, messages may come before their definitions
                deque(mcap.look_through(), maxlen=0)
            for chunk in mcap.chunks_at(part.place for part in layout.in_time):
                yield mcap, chunk

    def _places(self, kinds: Sequence[str]) -> list[_Place] | None:
        """Where messages of some types may be; None if a file does not say so."""
        found: list[_Place] = []
        for file in self.files:
            with self.opened(file) as mcap:
                if not mcap.lists_all:
                    return None
                wanted = {topic.name for topic in mcap.topics if topic.kind in kinds}
                spans = (span for span in mcap.spans() if wanted & span.topics)
                found += [_Place(file, span.place, span.first_ns, span.last_ns) for span in spans]
        return found

    def _first_place(self, places: Sequence[_Place], window: RunWindow) -> int:
        """Number of the place to begin with: the search relies on one run in the order of time, or begins at 0."""
        if self.disordered or not places:
            return 0
        start: int | None = None
        alike = True

        def sample(number: int) -> tuple[int, float] | None:
            nonlocal start, alike
            found = self._first_sample(places[number])
            if found is None:
                return None
            step, time, begun = found
            start = begun if start is None else start
            alike = alike and abs(begun - start) <= SAME_START
            return step, time

        first = first_chunk(len(places), window, sample)
        if not alike:
            return 0
        # Topics may be stored apart: everything from the time of that sample on is read.
        return next(number for number, place in enumerate(places) if place.last_ns >= places[first].first_ns)

    def _first_sample(self, place: _Place) -> tuple[int, float, int] | None:
        """Step and time of the first contact forces in a chunk, and the time of step 0, ns."""
        with BagReader(self.path, _ignore, self._known, self._stored).opened(place.file) as mcap:
            for chunk in mcap.chunks_at([place.place]):
                for message in mcap.messages(chunk):
                    if message.topic.kind == FORCES:
                        found = Located(message, chunk, mcap)
                        forces = self.quiet.decoded(found)
                        return None if forces is None else self.quiet.made(found, partial(_beginning, forces))
        return None

    def _require_one(self, runs: Sequence[str]) -> None:
        if len(runs) > 1:
            raise RecordingError(
                f"{self.path} holds {len(runs)} runs ({', '.join(runs)}): record each run into a bag of its own, or "
                "extract one out by its topics with ros2 bag convert"
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
    return path.with_name(path.name.removesuffix(suffix_of(path)) + ending)


def _one_line(reason: BaseException) -> str:
    """Message of an error of a library."""
    text = " ".join(str(reason)[: 2 * LONGEST_REASON].split()) or type(reason).__name__
    return text if len(text) <= LONGEST_REASON else f"{text[:LONGEST_REASON]} ..."


def _beginning(forces: Any) -> tuple[int, float, int]:
    return int(forces.first_step), float(forces.time), start_of(forces)


def _ignore(loss: Loss) -> None:
    """Report nothing."""


def _incomplete(file: Path, what: str) -> RecordingError:
    return RecordingError(
        f"{file} is not a complete bag ({what}): it is damaged, was not closed, or is another kind of file"
    )
