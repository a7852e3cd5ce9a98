"""The messages of a bag in the order of time, of any topic and type, from any time on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.serde import SerdeError

from ...errors import RecordingError
from ..bag_reader import BagReader
from ..mcap.reader import Chunk, McapReader, Span
from ..topics import Topic
from .stamps import LATEST

if TYPE_CHECKING:
    from typing_extensions import Self


class Played(NamedTuple):
    """A message as it is played."""

    time_ns: int
    """When it was recorded, which sets when it is played. In bags of this project it is the stamp."""
    topic: str
    cdr: bytes
    begins: bool = False
    """Whether a chunk begins with it."""


@dataclass(frozen=True)
class _Spans:
    """The chunks of a file in the order of their first messages."""

    places: NDArray[np.int64]
    first_ns: NDArray[np.int64]
    last_ns: NDArray[np.int64]
    holding: dict[str, NDArray[np.int64]]
    """Which of them have messages of a topic."""


class RecordedBag:
    """A bag, a file or a folder, opened to be played; a context manager that closes its files.

    Files without an index are read once when the bag is opened. Unreadable parts are left out and listed in
    ``damages``.
    """

    def __init__(self, path: Path) -> None:
        """Open it; raises RecordingError in one line if there is nothing to play."""
        self.path = path
        self.damages: list[str] = []
        self.topics: dict[str, Topic] = {}
        self._reader = BagReader(path, self._damaged)
        self._reader.report_missing()
        self._files: list[tuple[McapReader, _Spans]] = []
        with ExitStack() as stack:
            for file in self._reader.files:
                with self._reporting(file.name):
                    mcap = stack.enter_context(self._reader.opened(file))
                    self._files.append((mcap, self._spans(mcap)))
            if not any(len(spans.places) for _, spans in self._files):
                found = f" ({'; '.join(self.damages)})" if self.damages else ""
                raise RecordingError(f"{path} holds no message that can be read{found}: give a bag of a run")
            self._stack = stack.pop_all()
        self.start_ns = min(int(spans.first_ns[0]) for _, spans in self._files if len(spans.places))
        """Time of the first message, ns."""
        self.last_ns = max(int(spans.last_ns.max()) for _, spans in self._files if len(spans.places))
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

    def messages(self, begin_ns: int, end_ns: int, topics: set[str]) -> Iterator[Played]:
        """Messages of ``topics`` from ``begin_ns`` on and before ``end_ns``, in the order of time within each file."""
        for mcap, spans in self._files:
            held: list[tuple[int, int, Played]] = []
            order = 0
            for number in np.flatnonzero((spans.last_ns >= begin_ns) & (spans.first_ns < end_ns)):
                while held and held[0][0] < spans.first_ns[number]:
                    yield heappop(held)[2]
                for message in self._read(mcap, int(spans.places[number])):
                    if begin_ns <= message.time_ns < end_ns and message.topic in topics:
                        heappush(held, (message.time_ns, order, message))
                        order += 1
            while held:
                yield heappop(held)[2]

    def last_before(self, topic: str, time_ns: int) -> Played | None:
        """The last message of a topic before a time, ns; None if there is none."""
        for mcap, spans in reversed(self._files):
            for number in spans.holding.get(topic, np.empty(0, np.int64))[::-1]:
                if spans.first_ns[number] < time_ns:
                    found = self._read(mcap, int(spans.places[number]))
                    earlier = [item for item in found if item.topic == topic and item.time_ns < time_ns]
                    if earlier:
                        return max(earlier, key=lambda item: item.time_ns)
        return None

    def _read(self, mcap: McapReader, place: int) -> Sequence[Played]:
        """Messages of a chunk; none if it cannot be read."""
        with self._reporting(mcap.name):
            for chunk in mcap.chunks_at([place]):
                return _played(mcap, chunk)
        return ()

    def _spans(self, mcap: McapReader) -> _Spans:
        """Where the chunks of a file are; notes its topics on the way."""
        spans = [span for span in (self._within_time(mcap, span) for span in mcap.spans()) if span.first_ns <= LATEST]
        mcap.release()
        for topic in mcap.topics:
            self.topics.setdefault(topic.name, topic)
        spans.sort(key=lambda span: (span.first_ns, span.last_ns, span.place))
        holding = {topic.name: np.flatnonzero([topic.name in span.topics for span in spans]) for topic in mcap.topics}
        places, first, last = np.array([span[:3] for span in spans], np.int64).reshape(-1, 3).T
        return _Spans(places, first, last, holding)

    def _within_time(self, mcap: McapReader, span: Span) -> Span:
        """A span without messages of times that cannot be played, which are reported."""
        if span.last_ns <= LATEST:
            return span
        self._damaged(f"{mcap.name}: messages after {LATEST} ns are left out, for ROS has no such times")
        if span.first_ns > LATEST:
            return span
        times = [message.time_ns for message in self._read(mcap, span.place)]
        return span._replace(last_ns=max(times, default=span.first_ns))

    @contextmanager
    def _reporting(self, file: str) -> Iterator[None]:
        """Report errors of the disk, and of a file that cannot be opened, as damage."""
        try:
            yield
        except RecordingError as reason:
            self._damaged(reason)
        except OSError as reason:
            self._damaged(f"{file}: {reason.strerror}")

    def _damaged(self, what: object) -> None:
        if str(what) not in self.damages:
            self.damages.append(str(what))


def _played(mcap: McapReader, chunk: Chunk) -> list[Played]:
    """Messages of a chunk, those of earlier versions of this package as they are today."""
    found = []
    for item in mcap.messages(chunk):
        if item.log_time > LATEST:
            continue
        data, conversion = bytes(item.data), item.topic.conversion
        if conversion is not None:
            try:
                data = conversion(data)
            except SerdeError:  # of another type than its definition says
                continue
        found.append(Played(item.log_time, item.topic.name, data))
    return found
