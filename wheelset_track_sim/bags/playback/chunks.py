"""Where chunks begin among the messages of a bag, and how long they last."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from ..definitions import PACKAGE, deserialise
from .recorded_bag import Recorded

LEADING = {"ContactForces": "wheel_1", "AxleStress": "max_principal", "LoadSummary": ""}
"""Messages of which each chunk has one, by their types, with a field that has an entry a sample.

The first of these that a bag has leads its chunks.
"""
LONGEST = 2 * 10**9
"""Time, ns, that is looked ahead for the next chunk; chunks of the node last a second at most."""


class Played(NamedTuple):
    """A message, and whether a chunk begins with it."""

    message: Recorded
    begins: bool


def leading_topic(kinds: Mapping[str, str]) -> str | None:
    """The topic that leads the chunks, of all topics with their types; None if none does."""
    for kind in LEADING:
        for topic, found in kinds.items():
            if found == f"{PACKAGE}/msg/{kind}":
                return topic
    return None


def chunked(messages: Iterable[Recorded], leading: str | None) -> Iterator[Played]:
    """Messages in their order; a chunk begins with the first message of the time of a message of the leading topic.

    Without such a topic each message is a chunk. A chunk is read whole before its first message is yielded, so that no
    reading comes between its messages.
    """
    if leading is None:
        yield from (Played(message, begins=True) for message in messages)
        return
    waiting: list[Played] = []
    for message in messages:
        waiting.append(Played(message, begins=False))
        if message.topic == leading:
            first = next(place for place, other in enumerate(waiting) if other.message.time_ns == message.time_ns)
            yield from waiting[:first]
            waiting = [waiting[first]._replace(begins=True), *waiting[first + 1 :]]
        while message.time_ns - waiting[0].message.time_ns > LONGEST:
            yield waiting.pop(0)
    yield from waiting


def span_ns(kind: str, cdr: bytes) -> int:
    """Time from the first sample of a leading message to behind its last, ns; raises rosbags' SerdeError."""
    short = kind.rpartition("/")[2]
    message = deserialise(short, cdr)
    samples: int = len(getattr(message, LEADING[short])) if LEADING[short] else message.samples
    return round(samples * float(message.step_period) * 1e9)
