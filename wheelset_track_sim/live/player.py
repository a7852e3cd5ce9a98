"""Play a bag: each message at its time, with pause, seek, rate and steps."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol

from ..bags.playback.recorded_bag import Played
from ..errors import InputError
from ..inputs.schema import check, quantity, quantity_of
from .pacing import Clock, Pacer, SteadyClock

SECOND = 10**9
POLL = 0.02
"""Time after which a player that is held asks again whether it may begin, s."""
REST = 3600.0
"""Longest sleep of a paused player, s; a command wakes it earlier."""
LONGEST = 1e7
"""Longest time in a bag, s."""


@dataclass(frozen=True)
class Playback:
    """The part of a bag to play, and its speed; times are of the bag, from its first message on."""

    rate: float = quantity(
        "", 0.0, 1000.0, "the bag's time over the elapsed time, 0 for as fast as possible,", default=1.0
    )
    start_offset: float = quantity("s", 0.0, LONGEST, "the time in the bag at which the replay begins", default=0.0)
    duration: float = quantity(
        "s", 0.0, LONGEST, "the time in the bag after which the replay ends, 0 for all of it,", default=0.0
    )
    loop: bool = False
    """Begin again at the end."""
    start_paused: bool = False
    """Wait for ``resume``."""

    def __post_init__(self) -> None:
        check(self)


RATE = quantity_of(Playback, "rate")


class MessageSource(Protocol):
    """The part of a bag as a player reads it."""

    @property
    def start_ns(self) -> int:
        """Time of the first message, ns."""
        ...

    @property
    def end_ns(self) -> int:
        """End of the last chunk, ns."""
        ...

    def played(self, begin_ns: int, end_ns: int) -> Iterator[Played]:
        """Messages from ``begin_ns`` on and before ``end_ns``, in the order of time."""
        ...


@dataclass
class Punctuality:
    """Delays of messages."""

    messages: int = 0
    worst: float = 0.0
    """Largest delay, s."""

    def add(self, lag: float) -> None:
        """One more message."""
        self.messages += 1
        self.worst = max(self.worst, lag)


class Player:
    """Plays a bag in ``run``, until it ends or ``stop`` is called; all other methods may be called from any thread.

    ``deliver`` is called with each message and the time played so far, ns. That time never goes back: it continues
    through loops and seeks, and differs between consecutive messages as their times in the bag do. ``moved`` is called
    before the first message, and whenever another part of the bag follows, with the beginning of the part, ns, and the
    time played so far, ns. ``ended`` is called once, unless ``stop`` ends the player: with None, or with the exception
    that was raised.

    Commands are executed between two messages by the thread of ``run``, in their order. Each method returns the future
    of its command, which raises InputError if it cannot be done.
    """

    def __init__(
        self,
        source: MessageSource,
        playback: Playback,
        deliver: Callable[[Played, int], None],
        moved: Callable[[int, int], None],
        ended: Callable[[Exception | None], None],
        clock: Clock | None = None,
    ) -> None:
        """``clock`` paces the replay, by default the machine's; raises InputError if there is nothing to play."""
        self._source, self._deliver, self._moved, self._ended = source, deliver, moved, ended
        self._clock = clock or SteadyClock()
        self.loop = playback.loop
        self.punctuality = Punctuality()
        self._begin = source.start_ns + round(playback.start_offset * SECOND)
        length = round(playback.duration * SECOND)
        self._end = min(source.end_ns, self._begin + length) if length else source.end_ns
        if self._begin >= self._end:
            raise InputError(
                f"start_offset = {playback.start_offset:g} s is after the end of the bag: "
                f"give a time below {(source.end_ns - source.start_ns) / SECOND:g} s"
            )
        self._rate, self._paused = playback.rate, playback.start_paused
        self._lead = -self._begin  # played time less time in the bag, ns
        self._standing = 0  # played time while paused, ns
        self._progress = False  # whether a message has been played since the beginning of the part
        self._stopping = self._over = self._held = False
        self._following: Played | None = None
        self._commands: deque[tuple[Callable[[], Any], Future[Any]]] = deque()
        self._lock = threading.Lock()  # of the commands
        self._wake = threading.Event()
        self._schedule(0)

    @property
    def paused(self) -> bool:
        """Whether it waits for ``resume``."""
        return self._paused

    @property
    def rate(self) -> float:
        """The bag's time over the elapsed time; 0 is as fast as possible."""
        return self._rate

    @property
    def position_ns(self) -> int:
        """Time in the bag that has been reached, ns."""
        return self._reached() - self._lead

    def stop(self) -> None:
        """End ``run`` after the current message."""
        self._stopping = True
        self._wake.set()

    def pause(self) -> Future[None]:
        """Pause after the current message."""
        return self._order(self._pause)

    def resume(self) -> Future[None]:
        """Continue after a pause."""
        return self._order(self._resume)

    def toggle(self) -> Future[None]:
        """Pause or resume."""
        return self._order(lambda: self._resume() if self._paused else self._pause())

    def set_rate(self, rate: float) -> Future[None]:
        """Continue at another rate; raises InputError for one that is out of range."""
        refusal = RATE.refusal("rate", rate)
        if refusal:
            raise InputError(refusal)
        return self._order(lambda: self._set_rate(rate))

    def seek(self, time_ns: int) -> Future[None]:
        """Continue from another time in the bag, ns; raises InputError for one that is not played."""
        if not self._begin <= time_ns < self._end:
            first, last = ((time - self._source.start_ns) / SECOND for time in (self._begin, self._end))
            wanted = (time_ns - self._source.start_ns) / SECOND
            raise InputError(
                f"position = {wanted:g} s is out of range: give a time from {first:g} s to before {last:g} s"
            )
        return self._order(lambda: self._go_to(time_ns, self._reached()))

    def restart(self) -> Future[None]:
        """Continue from the beginning."""
        return self.seek(self._begin)

    def step(self, chunks: int = 1) -> Future[int]:
        """While paused, play as many chunks at once, or until the end; returns their number."""
        return self._order(lambda: sum(self._burst(until_chunk=True) > 0 for _ in range(chunks)))

    def burst(self, messages: int = 0) -> Future[int]:
        """While paused, play as many messages at once, or all if 0; returns their number."""
        return self._order(lambda: self._burst(messages or None))

    def run(self, ready: Callable[[], bool] | None = None) -> None:
        """Play in the calling thread; the schedule starts now, or when it is ``ready``.

        Until then the player is paused; ``pause``, ``resume`` and ``toggle`` end the wait.
        """
        failure: Exception | None = None
        try:
            self._go_to(self._begin, 0)
            if ready is not None and not self._paused:
                self._hold(ready)
            self._play()
        except Exception as raised:  # noqa: BLE001  passed to ``ended``
            failure = raised
        with self._lock:
            self._over = True
        self._execute()
        if failure is not None or not self._stopping:
            self._ended(failure)

    def _hold(self, ready: Callable[[], bool]) -> None:
        self._pause()
        self._held = True
        while self._held and not (self._stopping or ready()):
            self._wake.wait(POLL)
            self._wake.clear()
            self._execute()
        if self._held:
            self._resume()

    def _play(self) -> None:
        while not self._stopping:
            self._execute()
            following = self._following
            if self._paused:
                self._clock.sleep(self._clock.now() + REST, self._wake)
                self._wake.clear()
            elif self._wait(following) > 0:
                self._pacer.sleep(self._due(following) / SECOND, self._wake)
                self._wake.clear()
            elif following is not None:
                self._hand_over(following)
            elif not self._rewind():
                return

    def _order(self, action: Callable[[], Any]) -> Future[Any]:
        future: Future[Any] = Future()
        with self._lock:
            if self._over:
                future.set_exception(_over())
            else:
                self._commands.append((action, future))
        self._wake.set()
        return future

    def _execute(self) -> None:
        while self._commands:
            action, future = self._commands.popleft()
            try:
                if self._over:
                    raise _over()
                future.set_result(action())
            except InputError as refusal:
                future.set_exception(refusal)

    def _pause(self) -> None:
        self._held = False
        if not self._paused:
            self._standing, self._paused = self._reached(), True

    def _resume(self) -> None:
        self._held = False
        if self._paused:
            self._paused = False
            self._schedule(self._standing)

    def _set_rate(self, rate: float) -> None:
        reached = self._reached()
        self._rate = rate
        self._schedule(reached)

    def _burst(self, messages: int | None = None, *, until_chunk: bool = False) -> int:
        if not self._paused:
            raise InputError("the replay is running: pause it first")
        count, chunks = 0, 0
        while not self._stopping and (messages is None or count < messages):
            following = self._following
            if following is None:
                if count or not (self.loop and self._rewind()):
                    break
                continue
            chunks += following.begins
            if until_chunk and following.begins and chunks > 1:
                break
            self._standing = self._due(following)
            self._hand_over(following)
            count += 1
        self._standing = max(self._standing, self._due(self._following)) if count else self._standing
        return count

    def _hand_over(self, following: Played) -> None:
        self._deliver(following, self._due(following))
        self.punctuality.add(0.0 if self._paused else max(0.0, -self._wait(following)))
        self._progress = True
        self._advance()

    def _rewind(self) -> bool:
        """Begin again, if ``loop`` is set and there is something to play."""
        if not (self.loop and self._progress):
            return False
        self._go_to(self._begin, self._due(None), keep=True)
        return True

    def _go_to(self, time_ns: int, played_ns: int, *, keep: bool = False) -> None:
        """Continue from ``time_ns`` in the bag, when ``played_ns`` have been played; ``keep`` the schedule for that."""
        self._lead = played_ns - time_ns
        self._progress = False
        self._parts = self._source.played(time_ns, self._end)
        self._moved(time_ns, played_ns)
        self._advance()
        if not keep:
            self._standing = played_ns
            self._schedule(played_ns)

    def _advance(self) -> None:
        self._following = next(self._parts, None)

    def _schedule(self, played_ns: int) -> None:
        self._pacer = Pacer(self._rate, played_ns / SECOND, self._clock)

    def _due(self, following: Played | None) -> int:
        """Played time at which a message is due, or the end if there is none, ns."""
        return self._lead + (self._end if following is None else following.time_ns)

    def _wait(self, following: Played | None) -> float:
        return self._pacer.wait(self._due(following) / SECOND)

    def _reached(self) -> int:
        """Played time that has been reached, ns."""
        if self._paused:
            return self._standing
        due = self._due(self._following)
        return due if self._rate == 0 else min(due, round(self._pacer.now() * SECOND))


def _over() -> InputError:
    return InputError("the replay is over: start it again")
