"""What of a bag is played: topics that can be published here, in chunks, from the beginning to behind the last one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from rosbags.serde import SerdeError

from .chunks import Played, chunked, leading_topic, span_ns
from .recorded_bag import Recorded, RecordedBag
from .topics import Topic

REST = 100_000_000
"""Time, ns, before a bag without chunks begins again."""


class Selection:
    """Some topics of a bag."""

    def __init__(self, bag: RecordedBag, topics: dict[str, Topic]) -> None:
        """Of an open bag."""
        self._bag, self._topics = bag, topics
        self.leading = leading_topic({name: topic.kind for name, topic in topics.items()})
        """The topic whose messages lead the chunks; None if each message is a chunk."""
        self.start_ns = bag.start_ns
        """Time of the first message, ns."""
        last = bag.last_before(self.leading, bag.last_ns + 1) if self.leading else None
        self.end_ns = max(bag.last_ns + 1, last.time_ns + self.span_ns(last)) if last else bag.last_ns + REST
        """Time behind the last chunk, ns."""

    def played(self, begin_ns: int, end_ns: int) -> Iterator[Played]:
        """Messages from ``begin_ns`` on and before ``end_ns``, in the order of time."""
        return chunked(self._bag.messages(begin_ns, end_ns, {*self._topics}), self.leading)

    def held_at(self, time_ns: int) -> Iterator[Recorded]:
        """What late subscribers are told at a time: the last message before it on each topic that is kept for them."""
        for name, topic in self._topics.items():
            found = self._bag.last_before(name, time_ns) if topic.latched else None
            if found is not None:
                yield found

    def span_ns(self, message: Recorded) -> int:
        """Time from the first sample of a message to behind its last, ns; 0 if it does not lead a chunk."""
        if message.topic == self.leading:
            with suppress(SerdeError):
                return span_ns(self._topics[message.topic].kind, message.cdr)
        return 0
