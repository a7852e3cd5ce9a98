"""The part of a bag that is played: topics that can be published here, cut into chunks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress

from ..bag_reader import DAMAGE
from ..definitions import deserialise
from ..topics import Topic
from .recorded_bag import Played, RecordedBag

LEADING = {"ContactForces": "wheel_1", "AxleStress": "max_principal", "LoadSummary": ""}
"""Types of messages that may lead chunks, because each chunk has one, with a field that has an entry a sample.

The first type that a bag holds leads its chunks.
"""
LONGEST = 2 * 10**9
"""Time, ns, within which the next chunk is looked for; chunks of the node last a second at most."""
REST = 100_000_000
"""Time, ns, before a bag without chunks begins again."""


class Selection:
    """Some topics of a bag."""

    def __init__(self, bag: RecordedBag, topics: Mapping[str, Topic]) -> None:
        """Select ``topics`` of an open bag."""
        self._bag, self._topics = bag, topics
        self.leading = leading_topic(topics)
        """The topic whose messages lead the chunks; None if each message is a chunk."""
        self.start_ns = bag.start_ns
        """Time of the first message, ns."""
        last = bag.last_before(self.leading, bag.last_ns + 1) if self.leading else None
        self.end_ns = max(bag.last_ns + 1, last.time_ns + self.span_ns(last)) if last else bag.last_ns + REST
        """End of the last chunk, ns."""

    def played(self, begin_ns: int, end_ns: int) -> Iterator[Played]:
        """Messages from ``begin_ns`` on and before ``end_ns``, in the order of time."""
        return chunked(self._bag.messages(begin_ns, end_ns, {*self._topics}), self.leading)

    def held_at(self, time_ns: int) -> Iterator[Played]:
        """The messages that a late subscriber receives at a time: the last one before it on each latched topic."""
        for name, topic in self._topics.items():
            found = self._bag.last_before(name, time_ns) if topic.latched else None
            if found is not None:
                yield found

    def span_ns(self, message: Played) -> int:
        """Duration of the samples of a message, ns; 0 if it does not lead a chunk."""
        if message.topic == self.leading:
            with suppress(*DAMAGE):
                return min(max(0, span_ns(self._topics[message.topic].kind, message.cdr)), LONGEST)
        return 0


def leading_topic(topics: Mapping[str, Topic]) -> str | None:
    """The topic that leads the chunks; None if there is none."""
    for kind in LEADING:
        for name, topic in topics.items():
            if topic.kind == kind:
                return name
    return None


def chunked(messages: Iterable[Played], leading: str | None) -> Iterator[Played]:
    """Messages in their order; a chunk begins with the first message of the time of a message of the leading topic.

    Without such a topic each message is a chunk. A chunk is read completely before its first message is yielded, so
    that its messages are not delayed by reading.
    """
    if leading is None:
        yield from (message._replace(begins=True) for message in messages)
        return
    waiting: list[Played] = []
    for message in messages:
        waiting.append(message)
        if message.topic == leading:
            first = next(place for place, other in enumerate(waiting) if other.time_ns == message.time_ns)
            yield from waiting[:first]
            waiting = [waiting[first]._replace(begins=True), *waiting[first + 1 :]]
        while message.time_ns - waiting[0].time_ns > LONGEST:
            yield waiting.pop(0)
    yield from waiting


def span_ns(kind: str, cdr: bytes) -> int:
    """Duration of the samples of a leading message, ns; raises rosbags' SerdeError."""
    message = deserialise(kind, cdr)
    samples: int = len(getattr(message, LEADING[kind])) if LEADING[kind] else message.samples
    return round(samples * float(message.step_period) * 1e9)
