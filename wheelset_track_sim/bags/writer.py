"""What every writer of a run has: blocks, impacts and states in, and an orderly end."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from ..errors import InputError, RecordingError
from ..samples.block import SampleBlock
from ..samples.impacts import Impact
from ..samples.summary import Summary
from ..samples.turns import NO_TURN, TurnPeaks
from .messages import Message, State, chunk_messages, impact_message, state_message

if TYPE_CHECKING:
    from typing_extensions import Self

PREFIX = "/wheelset_track_sim"


class Writer(ABC):
    """A context manager that leaves what can be read, also after an exception; one thread writes."""

    def __init__(self, path: Path, start_ns: int) -> None:
        """``start_ns`` is the time stamp of step 0, ns since the epoch."""
        self.path, self.start_ns = path, start_ns

    @abstractmethod
    def write_messages(self, messages: Iterable[Message]) -> None:
        """Record messages that belong together: a chunk, a state, impacts.

        Raises RecordingError if the disk refuses; what is written is finished then, as far as the disk lets.
        """

    @abstractmethod
    def gap(self, note: str) -> None:
        """Tell that what comes next does not follow what was given; RecordingError if the disk refuses."""

    @abstractmethod
    def split(self) -> Path:
        """Go on in another file, which is returned; InputError if there is nothing to split, RecordingError."""

    @abstractmethod
    def snapshot(self) -> Path:
        """Write what is kept for snapshots, and return where; InputError if there is nothing, RecordingError."""

    @abstractmethod
    def sync(self) -> None:
        """Wait until what is at the operating system is on the disk, so that a power failure does not take it.

        Raises RecordingError if the disk refuses.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish; closing again does nothing. Raises RecordingError if the disk refuses."""

    @abstractmethod
    def remove_if_empty(self) -> None:
        """Remove what holds no message, when it is closed."""

    def write(
        self,
        block: SampleBlock,
        *,
        real_time_factor: float = math.nan,
        lag: float = 0.0,
        summary: Summary | None = None,
        turn: TurnPeaks = NO_TURN,
        impacts: Iterable[Impact] = (),
    ) -> None:
        """Record one block with the ``impacts`` that were over in it; RecordingError if the disk refuses.

        ``summary`` is that of the block if it is known already, ``turn`` the last complete turn of the wheels.
        """
        messages = chunk_messages(
            block, self.start_ns, real_time_factor=real_time_factor, lag=lag, summary=summary, turn=turn
        )
        self.write_messages(messages)
        self.write_impacts(impacts)

    def write_impacts(self, impacts: Iterable[Impact]) -> None:
        """Record impacts; RecordingError if the disk refuses."""
        self.write_messages(impact_message(impact, self.start_ns) for impact in impacts)

    def write_state(self, state: State) -> None:
        """Record what is simulated from a step on: at the start, and at every revision."""
        self.write_messages([state_message(state, self.start_ns)])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
            return
        with suppress(RecordingError):  # the first error is the one to tell
            self.close()
        self.remove_if_empty()


@contextmanager
def creating(path: Path) -> Iterator[None]:
    """Whatever keeps ``path`` from being created is an InputError in one line."""
    try:
        yield
    except OSError as reason:
        if isinstance(reason, FileExistsError) and path.exists():
            refusal = f"{path} exists already: give another path, or remove it first"
        else:
            why = "not a folder on the way" if isinstance(reason, FileExistsError) else reason.strerror
            refusal = f"{path} cannot be written ({why}): give a path in a folder that can be written"
        raise InputError(refusal) from None
