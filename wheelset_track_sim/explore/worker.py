"""One thread that works for all pages: of each page's requests of a kind only the latest one is answered."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import TypeAlias

Job: TypeAlias = Callable[[], None]


class SupersededError(Exception):
    """There is a newer request: the work on this one ends."""


class Worker:
    """Runs jobs one after the other, those of a lower ``rank`` first, in the order in which their places were taken.

    A job has a place: a page and a kind. A newer job takes the place of the one that waits there, so a page that asks
    often neither waits for what nobody wants any more, nor keeps another page waiting.
    """

    def __init__(self) -> None:
        self._waiting: OrderedDict[tuple[Hashable, str], tuple[int, Job]] = OrderedDict()
        self._changed = threading.Condition()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="explore", daemon=True)
        self._thread.start()

    def submit(self, page: Hashable, kind: str, job: Job, rank: int = 0) -> None:
        """Have a job done in place of an older one of that page and kind. A job must not raise."""
        with self._changed:
            self._waiting[page, kind] = rank, job
            self._changed.notify()

    def superseded(self, page: Hashable, kind: str) -> bool:
        """Whether a newer request waits, or the work ends."""
        with self._changed:
            return self._ended or (page, kind) in self._waiting

    def busy(self, rank: int) -> bool:
        """Whether a job of a rank below waits: work in the background makes room for it."""
        with self._changed:
            return self._ended or any(waiting < rank for waiting, _ in self._waiting.values())

    def drop(self, page: Hashable, kind: str | None = None) -> None:
        """Forget what waits for a page that is closed, or what of one kind waits."""
        with self._changed:
            for place in [each for each in self._waiting if each[0] == page and kind in (None, each[1])]:
                del self._waiting[place]

    def close(self) -> None:
        """End after the job at hand."""
        with self._changed:
            self._ended = True
            self._waiting.clear()
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._waiting)
                if self._ended:
                    return
                place = min(self._waiting, key=lambda each: self._waiting[each][0])  # the first of the lowest rank
                _, job = self._waiting.pop(place)
            job()
