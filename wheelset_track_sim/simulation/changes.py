"""Changes of a run: accepted whole, put in order, and installed when they take effect."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

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

    def branch(self) -> Condition:
        """The same with a copy of the last solution, from which those of another run go on."""
        return replace(self, law=self.law._replace(in_contact=self.law.in_contact.copy()))


@dataclass(frozen=True)
class Applied:
    """A change that has taken effect: all that it takes to make it again."""

    revision: Revision
    scenario: Scenario
    set_point: float
    """Speed that is approached, m/s."""
    event: Event | None = None
    """Event that made the change; None if it came from outside."""


class Changes:
    """Conditions in the order in which they take effect; one thread runs, any thread adds."""

    def __init__(self, first: Condition, tread_origin: int) -> None:
        self._lock, self._adding = threading.Lock(), threading.Lock()
        self._in_force, self._tread_origin = first, tread_origin
        self._queue: deque[Condition] = deque()
        self._horizon = first.revision.step

    def copy(self) -> Changes:
        """The same changes, with contacts of their own, for a run that goes on by itself."""
        with self._lock:
            copied = Changes(self._in_force.branch(), self._tread_origin)
            copied._queue = deque(condition.branch() for condition in self._queue)
            copied._horizon = self._horizon
        return copied

    @property
    def in_force(self) -> Condition:
        """The condition of the latest step."""
        return self._in_force

    @property
    def newest(self) -> Condition:
        """The condition accepted last; it may take effect a little later."""
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
        """Accept a change, the next in ``number``, for the first step at which it can take effect.

        That is after the block at hand and all earlier changes, from ``not_before`` on, where nothing that changes is
        in a contact patch. If there is no such step within a turn of the wheel, or with ``exactly`` at that very step,
        the surfaces ``fade``: that makes the contact law of a fade from a step on, and its length in steps. At the
        start (``number`` 0) the wait is shorter.

        Raises OvertakenError if ``base`` is not the condition accepted last any more, InputError if one of the steps
        ``due`` has passed.

        The run goes on meanwhile. If it comes past the step before the change is complete, a later one is tried, twice
        as far ahead as the run has come.
        """
        with self._adding:
            lead = 0
            while True:
                last, earliest = self.newest, max(self._horizon, not_before)
                if base not in (None, last):
                    raise OvertakenError("another change came first: try again")
                first = max(earliest + lead, last.from_step)
                step = passage(last.law, law, first, self._tread_origin)
                wait = 0 if exactly else START * len(law.x) if number == 0 else math.inf
                if step is not None and step > first + wait:
                    step = None
                begin = first if step is None else step
                revision = Revision(last.revision.number + 1 if number is None else number, begin)
                queued, from_step = [], begin
                if step is None:
                    fading, steps = fade(begin)
                    queued.append(Condition(revision, scenario, fading, preload, begin, begin - len(fading.x), event))
                    from_step += steps
                queued.append(Condition(revision, scenario, law, preload, from_step, self._tread_origin, event))
                with self._lock:
                    self._check_due(due)
                    if self._horizon <= begin:
                        self._queue.extend(queued)
                        return revision
                    lead = 2 * (self._horizon - earliest)

    def _check_due(self, due: Iterable[int]) -> None:
        """Raise InputError for an event that has passed."""
        for step in due:
            if step < self._horizon:
                raise InputError(
                    f"an event at step {step} is in the past: the run is at step {self._horizon}, give a later one"
                )

    def due(self, step: int) -> Iterator[Condition]:
        """Conditions that take effect up to ``step``, one after the other."""
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
