"""The messages of a bag as they were recorded, of any topic and type, from any time on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import RecordingError
from ..files import files_of, missing_files
from ..losses import Damage
from ..mcap.records import Chunk
from ..mcap.source import McapSource
from .topics import Topic

if TYPE_CHECKING:
    from typing_extensions import Self


class Recorded(NamedTuple):
    """A message as it was recorded."""

    time_ns: int
    """When it was recorded: by this bags are played. In bags of this project it is the stamp."""
    topic: str
    cdr: bytes


@dataclass(frozen=True)
class Chunks:
    """Where the chunks of a file are, in the order of their first messages."""

    places: NDArray[np.int64]
    first_ns: NDArray[np.int64]
    last_ns: NDArray[np.int64]
    holding: dict[str, NDArray[np.int64]]
    """Which of them have messages of a topic."""


class RecordedBag:
    """A bag, a file or a folder, opened to be played; a context manager that closes its files.

    Files without an index are gone through once when the bag is opened; what cannot be read there or later is named in
    ``damages`` and left out.
    """

    def __init__(self, path: Path) -> None:
        """Open it; raises RecordingError in one line if there is nothing to be played."""
        self.path = path
        self.damages: list[str] = [str(damage) for damage in missing_files(path)]
        self.topics: dict[str, Topic] = {}
        self._files: list[tuple[McapSource, Chunks]] = []
        with ExitStack() as stack:
            for file in files_of(path):
                self._open(file, stack)
            if not any(len(chunks.places) for _, chunks in self._files):
                told = f" ({'; '.join(self.damages)})" if self.damages else ""
                raise RecordingError(f"{path} holds no message that can be read{told}: give a bag of a run")
            self._stack = stack.pop_all()
        self.start_ns = min(int(chunks.first_ns[0]) for _, chunks in self._files if len(chunks.places))
        """Time of the first message, ns."""
        self.last_ns = max(int(chunks.last_ns.max()) for _, chunks in self._files if len(chunks.places))
        """Time of the last message, ns."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close its files; closing again does nothing."""
        self._stack.close()

    def messages(self, begin_ns: int, end_ns: int, topics: set[str]) -> Iterator[Recorded]:
        """Messages of ``topics`` from ``begin_ns`` on and before ``end_ns``, in the order of time within each file."""
        for source, chunks in self._files:
            held: list[tuple[int, int, Recorded]] = []
            order = 0
            for number in np.flatnonzero((chunks.last_ns >= begin_ns) & (chunks.first_ns < end_ns)):
                while held and held[0][0] < chunks.first_ns[number]:
                    yield heappop(held)[2]
                for message in self._read(source, int(chunks.places[number])):
                    if begin_ns <= message.time_ns < end_ns and message.topic in topics:
                        heappush(held, (message.time_ns, order, message))
                        order += 1
            while held:
                yield heappop(held)[2]

    def last_before(self, topic: str, time_ns: int) -> Recorded | None:
        """The last message of a topic before a time, ns; None if there is none."""
        for source, chunks in reversed(self._files):
            for number in chunks.holding.get(topic, np.empty(0, np.int64))[::-1]:
                if chunks.first_ns[number] < time_ns:
                    found = self._read(source, int(chunks.places[number]))
                    earlier = [item for item in found if item.topic == topic and item.time_ns < time_ns]
                    if earlier:
                        return max(earlier, key=lambda item: item.time_ns)
        return None

    def _open(self, file: Path, stack: ExitStack) -> None:
        try:
            source = McapSource(stack.enter_context(file.open("rb")), file.name)
            self._files.append((source, self._chunks(source)))
        except OSError as reason:
            self._damaged(f"{file.name}: {reason.strerror}")

    def _read(self, source: McapSource, place: int) -> Sequence[Recorded]:
        try:
            [chunk] = source.chunks_at([place])
        except OSError as reason:
            chunk = Damage(self.path.name, place, place, str(reason.strerror))
        if isinstance(chunk, Damage):
            self._damaged(str(chunk))
            return ()
        return self._within(source, chunk)

    def _within(self, source: McapSource, chunk: Chunk) -> list[Recorded]:
        found: list[Recorded] = []
        for item in source.messages(chunk):
            if isinstance(item, Damage):
                self._damaged(str(item))
            else:
                found.append(Recorded(item.log_time, item.channel.topic, bytes(item.data)))
        return found

    def _chunks(self, source: McapSource) -> Chunks:
        """Where the chunks of a file are; it tells topics and damages by the way."""
        spans: list[tuple[int, int, int, set[str]]] = []  # first and last time, place, topics
        if source.index is not None:
            names = {number: channel.topic for number, channel in source.channels.items()}
            for item in source.index.chunks:
                within = {names[number] for number in item.message_index_offsets if number in names}
                if within or item.message_end_time:
                    place = item.chunk_start_offset
                    spans.append((item.message_start_time, item.message_end_time, place, within or {*names.values()}))
            source.index.chunks.clear()  # which takes a hundred times the room of ours
        else:
            for part in source.scan():
                if isinstance(part, Damage):
                    self._damaged(str(part))
                elif isinstance(part, Chunk) and (found := self._within(source, part)):
                    times = [message.time_ns for message in found]
                    spans.append((min(times), max(times), part.place, {message.topic for message in found}))
        for channel, schema in source.topics():
            self.topics.setdefault(channel.topic, Topic.of(channel, schema))
        spans.sort(key=lambda span: span[:3])
        topics = {channel.topic for channel in source.channels.values()}
        holding = {name: np.flatnonzero([name in span[3] for span in spans]) for name in topics}
        first, last, places = np.array([span[:3] for span in spans], np.int64).reshape(-1, 3).T
        return Chunks(places, first, last, holding)

    def _damaged(self, what: str) -> None:
        if what not in self.damages:
            self.damages.append(what)
