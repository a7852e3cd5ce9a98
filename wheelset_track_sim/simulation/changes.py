"""Changes of a run: accepted whole, put in order, and installed when they come into force."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from ..contact.law_kernels import ContactLaw
from ..errors import InputError, WheelsetTrackError
from ..runtime.arrays import Real
from ..scenario import Event, Scenario
from .passage import passage

START = 6
"""Lengths of the contact area for which what is in it at the start may wait: longer things are there at once."""


class OvertakenError(WheelsetTrackError):
    """Another change was accepted while this one was worked out: it has to be made from that one."""


@dataclass(frozen=True)
class Revision:
    """An accepted change: its number, and the step from which it is in force."""

    number: int
    step: int


@dataclass(frozen=True, eq=False)
class Condition:
    """What a run stands under from a revision on."""

    revision: Revision
    scenario: Scenario
    law: ContactLaw
    preload: Real
    """Approach of each wheel under the static load without dynamics, (2,) m."""
    from_step: int
    """First step of these surfaces: that of the revision, or the end of the fade to them."""
    tread_origin: int
    """Step at row 0 of the law's treads."""
    event: Event | None = None
    """Event that made the change; None if it came from outside."""


@dataclass(frozen=True)
class Applied:
    """A change that has come into force: all that it takes to make it again."""

    revision: Revision
    scenario: Scenario
    set_point: float
    """Speed that is approached, m/s."""
    event: Event | None = None
    """Event that made the change; None if it came from outside."""


class Changes:
    """Conditions in the order in which they come into force; one thread runs, any thread adds."""

    def __init__(self, first: Condition, tread_origin: int) -> None:
        self._lock = threading.Lock()
        self._in_force, self._tread_origin = first, tread_origin
        self._queue: deque[Condition] = deque()
        self._horizon = first.revision.step

    @property
    def in_force(self) -> Condition:
        """The condition of the latest step."""
        return self._in_force

    @property
    def newest(self) -> Condition:
        """The condition accepted last; it may come into force a little later."""
        with self._lock:
            return self._queue[-1] if self._queue else self._in_force

    def add(
        self,
        scenario: Scenario,
        law: ContactLaw,
        preload: Real,
        fade: Callable[[int], tuple[ContactLaw, int]],
        *,
        base: Condition | None = None,
        event: Event | None = None,
        due: Iterable[int] = (),
        not_before: int = 0,
        exactly: bool = False,
        number: int | None = None,
    ) -> Revision:
        """Accept a change, the next in ``number``, for the first step at which it can come into force.

        That is after the block at hand and all earlier changes, from ``not_before`` on, where nothing that changes is
        in a contact patch. If there is no such step within a turn of the wheel, or with ``exactly`` at that very step,
        the surfaces ``fade``: that makes the contact law of a fade from a step on, and its length in steps. At the
        start (``number`` 0) the wait is shorter.

        Raises OvertakenError if ``base`` is not the condition accepted last any more, InputError if one of the steps
        ``due`` has passed.
        """
        with self._lock:
            last = self._queue[-1] if self._queue else self._in_force
            if base not in (None, last):
                raise OvertakenError("another change came first: try again")
            for step_due in due:
                if step_due < self._horizon:
                    raise InputError(
                        f"an event at step {step_due} is in the past: the run is at step {self._horizon}, give a later "
                        "one"
                    )
            earliest = max(self._horizon, last.from_step, not_before)
            step = passage(last.law, law, earliest, self._tread_origin)
            wait = 0 if exactly else START * len(law.x) if number == 0 else math.inf
            if step is not None and step > earliest + wait:
                step = None
            number = last.revision.number + 1 if number is None else number
            revision = Revision(number, earliest if step is None else step)
            begin = revision.step
            if step is None:
                fading, steps = fade(begin)
                row_0 = begin - len(fading.x)
                self._queue.append(Condition(revision, scenario, fading, preload, begin, row_0, event))
                begin += steps
            self._queue.append(Condition(revision, scenario, law, preload, begin, self._tread_origin, event))
        return revision

    def due(self, step: int) -> Iterator[Condition]:
        """Conditions that come into force up to ``step``, one after the other."""
        while True:
            with self._lock:
                if not self._queue or self._queue[0].from_step > step:
                    return
                self._in_force = self._queue.popleft()
            yield self._in_force

    def claim(self, end: int, due: Callable[[Scenario], int]) -> int:
        """The step before ``end``, or ``end``, up to which nothing changes any more: a block runs up to there.

        ``due`` is the step of the next event of a scenario.
        """
        with self._lock:
            newest = self._queue[-1] if self._queue else self._in_force
            end = min(end, due(newest.scenario))
            self._horizon = min(end, self._queue[0].from_step) if self._queue else end
            return self._horizon
