"""A writer in a thread of its own, so that a run does not wait for the disk."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

from ..errors import InputError, RecordingError
from .bag_writer import STATE, BagWriter
from .messages import Message
from .snapshots import IMPACT, SnapshotWriter

T = TypeVar("T")

SYNC_PERIOD = 1.0
"""Wall time between two waits for the disk, s, which a power failure can cost."""
SMALL = {STATE, IMPACT}
"""Messages that are kept when samples are lost, until ``RESERVE`` is used up."""
RESERVE = 1_000_000
"""Bytes for them beyond the size of the buffer."""


class BufferedWriter:
    """Passes messages on to a writer in their order; methods may be called from any thread, and do not wait for a disk.

    While ``size`` bytes wait for the disk, further samples are lost, but no states or impacts. When half of the buffer
    is free again, recording continues after a gap. If the disk refuses, recording ends.
    """

    def __init__(
        self, writer: BagWriter | SnapshotWriter, size: int, report: Callable[[RecordingError, bool], None]
    ) -> None:
        """``report`` is called in any thread with what is lost and why, and whether the recording has ended."""
        self.path = writer.path
        self._writer, self._size, self._report = writer, size, report
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="recorder")
        self._room = threading.Condition()
        self._waiting = 0
        self._shut_down = False
        self._failure: RecordingError | None = None
        self._gap: tuple[int, int] | None = None  # first and last step that is lost
        self._synced = time.monotonic()
        self._sync = False

    @property
    def waiting(self) -> int:
        """Bytes that wait for the disk."""
        return self._waiting

    def put(self, messages: Iterable[Message], *, patient: bool = False) -> None:
        """Write messages that belong together; with ``patient``, wait until there is room.

        A patient run keeps no time and can be repeated, so nothing is synced to the disk.
        """
        together = [message.packed() for message in messages]
        size = _size_of(together)
        with self._room:
            if patient:
                self._room.wait_for(lambda: self._shut_down or self._fits(size))
            if self._shut_down or not together:
                return
            if self._gap is not None and self._waiting <= self._size // 2:
                self._go_on(self._gap)
            if self._gap is not None or not self._fits(size):
                together = self._lose(together)
            if together:
                self._submit(self._write, together, not patient, size=_size_of(together))

    def split(self) -> Future[Path]:
        """Continue in another file, the result; it raises the errors of the writer."""
        with self._room:
            return self._submit(self._writer.split)

    def snapshot(self) -> Future[Path]:
        """Write the messages that are kept; the result is the path, and raises the errors of the writer."""
        with self._room:
            return self._submit(self._writer.snapshot)

    def close(self) -> Future[str]:
        """Take no more messages, and close the bag after those that wait; the result is its path."""
        return self._close_by(self._close)

    def discard(self) -> Future[str]:
        """Close a bag that is not needed, and remove it if it is empty."""
        return self._close_by(self._close_and_remove)

    def _close_by(self, close: Callable[[], str]) -> Future[str]:
        with self._room:
            if self._gap is not None:
                self._report(RecordingError(self._missing(self._gap)), False)
            closing = self._submit(close)
            self._shut()
        return closing

    def _fits(self, size: int) -> bool:
        return self._waiting == 0 or self._waiting + size <= self._size

    def _lose(self, together: list[Message]) -> list[Message]:
        """The messages that are kept although there is no room; the first lost sample is reported."""
        for fields in (message.fields for message in together if "samples" in message.fields):
            first, last = fields["first_step"], fields["first_step"] + fields["samples"] - 1
            if self._gap is None:
                self._report(RecordingError(self._missing((first, None))), False)
            self._gap = first if self._gap is None else self._gap[0], last
        small = [message for message in together if message.kind in SMALL]
        if self._waiting + _size_of(small) <= self._size + RESERVE:
            return small
        self._submit(self._close)
        self._shut()
        self._report(RecordingError(f"{self.path} ends here: the disk does not respond, and the buffer is full"), True)
        return []

    def _go_on(self, gap: tuple[int, int]) -> None:
        """End a gap, for there is room again."""
        note, self._gap = self._missing(gap), None
        self._submit(self._writer.gap, note)
        self._report(RecordingError(note), False)

    def _missing(self, gap: tuple[int, int | None]) -> str:
        to = "on" if gap[1] is None else f"to {gap[1]}"
        return f"{self.path} misses steps {gap[0]} {to}: the disk is too slow, {self._size:g} bytes wait for it already"

    def _close(self) -> str:
        self._writer.close(sync=self._sync)
        return str(self.path)

    def _close_and_remove(self) -> str:
        try:
            return self._close()
        finally:
            self._writer.remove_if_empty()

    def _write(self, together: list[Message], sync: bool) -> None:
        self._writer.write_messages(together)
        self._sync = sync
        if sync and time.monotonic() - self._synced > SYNC_PERIOD:
            self._writer.sync()
            self._synced = time.monotonic()

    def _submit(self, job: Callable[..., T], *arguments: Any, size: int = 0) -> Future[T]:
        if self._shut_down:
            refused: Future[T] = Future()
            refused.set_exception(InputError(f"{self.path} is no longer being recorded: start another recording"))
            return refused
        self._waiting += size
        return self._thread.submit(self._do, job, arguments, size)

    def _do(self, job: Callable[..., T], arguments: tuple[Any, ...], size: int) -> T:
        try:
            return self._try(job, arguments)
        finally:
            with self._room:
                self._waiting -= size
                self._room.notify_all()

    def _try(self, job: Callable[..., T], arguments: tuple[Any, ...]) -> T:
        if self._failure is not None:
            raise self._failure
        try:
            return job(*arguments)
        except InputError:
            raise
        except RecordingError as reason:
            self._fail(reason)
            raise
        except Exception as reason:
            failure = RecordingError(f"{self.path} cannot be written further: {reason!r}")
            self._fail(failure)
            raise failure from reason

    def _fail(self, reason: RecordingError) -> None:
        with self._room:
            self._failure = reason
            self._shut()
        self._report(reason, True)

    def _shut(self) -> None:
        self._shut_down = True
        self._thread.shutdown(wait=False)


def _size_of(messages: Iterable[Message]) -> int:
    return sum(len(message.cdr) for message in messages)
