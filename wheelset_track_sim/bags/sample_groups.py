"""Messages that belong together, put together: contact forces of a chunk and the stress of each node."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..samples.block import SampleBlock
from .messages import block_of

WAITING = 64
"""Chunks of samples that wait for messages of theirs; in a bag of this package none does."""


class SampleGroups:
    """Takes messages in any order, gives blocks when they are complete."""

    def __init__(self, topics: list[str]) -> None:
        """``topics`` of stress are those that a block needs, in the order of its nodes."""
        self.topics = topics
        self._waiting: dict[int, dict[str, Any]] = {}

    def add(self, topic: str, message: Any) -> SampleBlock | None:
        """The block that a message completes; contact forces have no topic, for there is one of them."""
        chunk = self._waiting.setdefault(message.first_step, {})
        chunk[topic] = message
        if len(chunk) <= len(self.topics):
            return None
        del self._waiting[message.first_step]
        return block_of(chunk[""], [chunk[topic] for topic in self.topics])

    def incomplete(self, waiting: int = 0) -> Iterator[str]:
        """The oldest incomplete chunks, in words, until no more than ``waiting`` are left."""
        while len(self._waiting) > waiting:
            first_step = next(iter(self._waiting))
            chunk = self._waiting.pop(first_step)
            missing = [topic or "contact forces" for topic in ("", *self.topics) if topic not in chunk]
            yield f"samples from step {first_step} on are incomplete without {', '.join(missing)}"
