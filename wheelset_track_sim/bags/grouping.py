"""Put together the messages of the same samples, and blocks in their order."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from .content import ContentError


class Stepped(Protocol):
    """Consecutive samples."""

    @property
    def first_step(self) -> int:
        """Step of the first one."""
        ...

    def __len__(self) -> int: ...


T = TypeVar("T", bound=Stepped)

HELD = 1 << 29
"""Bytes of messages, or of blocks, that wait for others."""


@dataclass
class Group:
    """Messages of the same samples, by their signals."""

    first_step: int
    messages: dict[str, Any] = field(default_factory=dict)
    size: int = 0
    """Bytes."""

    def missing(self, signals: Sequence[str], forces: str) -> str:
        """Which signals are not there, in words."""
        absent = [signal for signal in signals if signal not in self.messages]
        named = ", ".join("contact forces" if signal == forces else signal for signal in absent)
        return f"samples from step {self.first_step} on are incomplete without {named}"


class Groups:
    """Messages that wait for those of other signals."""

    def __init__(self, signals: Sequence[str]) -> None:
        self.signals = signals
        self.size = 0
        """Bytes that wait."""
        self._waiting: dict[int, Group] = {}

    def __iter__(self) -> Iterator[Group]:
        return iter(self._waiting.values())

    def add(self, signal: str, message: Any, size: int) -> Group | None:
        """Add a message of ``size`` bytes; its group, once that is complete.

        ContentError for a second message of the same samples: it cannot be told which of the two is right.
        """
        group = self._waiting.setdefault(message.first_step, Group(message.first_step))
        if signal in group.messages:
            raise ContentError(f"samples from step {message.first_step} on come twice")
        group.messages[signal] = message
        group.size += size
        self.size += size
        if len(group.messages) < len(self.signals):
            return None
        self._drop(group)
        return group

    def taken(self, end_step: int) -> list[Group]:
        """Groups that begin before a step, which wait no longer."""
        return self._take([group for group in self if group.first_step < end_step])

    def oldest(self, most: int) -> list[Group]:
        """The oldest groups that do not fit into ``most`` bytes, which wait no longer."""
        found, left = [], self.size
        for group in self:
            if left <= most:
                break
            found.append(group)
            left -= group.size
        return self._take(found)

    def _take(self, groups: list[Group]) -> list[Group]:
        for group in groups:
            self._drop(group)
        return groups

    def _drop(self, group: Group) -> None:
        del self._waiting[group.first_step]
        self.size -= group.size


def by_step(items: Iterable[T], size: Callable[[T], int], most: int = HELD) -> Iterator[T]:
    """Items by their steps, of a bag that holds them in another order; up to ``most`` bytes of them are held.

    Where steps come again, another run begins: what is held comes before it, and nothing after it.
    """
    steps: list[int] = []
    held: dict[int, T] = {}
    total = 0
    for item in items:
        place = bisect_left(steps, item.first_step)
        before = held[steps[place - 1]] if place else None
        again = before is not None and before.first_step + len(before) > item.first_step
        if again or (place < len(steps) and steps[place] < item.first_step + len(item)):
            yield from (held[step] for step in steps)
            yield item
            return
        insort(steps, item.first_step)
        held[item.first_step] = item
        total += size(item)
        while total > most:
            first = held.pop(steps.pop(0))
            total -= size(first)
            yield first
    yield from (held[step] for step in steps)
