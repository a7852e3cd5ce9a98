"""Snapshots: the parts of a run around its impacts, each a bag of its own."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Iterable, Sequence
from pathlib import Path

from ..errors import InputError, RecordingError
from .bag_writer import PREFIX, SECOND_NS, STATE, BagWriter, Writer, creating
from .folder_files import is_mcap
from .messages import Message
from .run_info import Input, RunInfo
from .settings import SNAPSHOT, RecordSettings

IMPACT = "WheelImpact"
LATE_NS = SECOND_NS
"""Time of the run kept beyond ``snapshot_duration``: an impact is reported when it has ended."""


class SnapshotWriter(Writer):
    """Keeps the latest messages in memory, and writes them at an impact, or when ``snapshot`` is called.

    A snapshot begins ``snapshot_duration`` before the largest force of the impact, or at the start of the run, and ends
    ``snapshot_after`` after the end of the impact. It includes impacts in this time. No message is in two snapshots.
    Each is a bag folder ``NAME/NAME_step_N`` of its own, N the step of the largest force. All snapshots of one writer
    take ``max_total_size`` at most: the oldest are removed first, the newest stays.
    """

    def __init__(
        self, path: str | Path, info: RunInfo, *, start_ns: int, prefix: str = PREFIX, settings: RecordSettings
    ) -> None:
        """Create the folder of the snapshots, ``path`` without ``.mcap``; ``start_ns`` is the time stamp of step 0, ns.

        Raises InputError if it exists or cannot be written.
        """
        self.path = Path(path).with_suffix("") if is_mcap(Path(path)) else Path(path)
        self.start_ns = start_ns
        self._info, self._prefix, self._settings = info, prefix, settings
        self._kept: deque[Sequence[Message]] = deque()
        self._state: Message | None = None  # in force before what is kept
        self._taken: list[BagWriter] = []
        self._bag: BagWriter | None = None
        self._end_ns = self._until_ns = start_ns
        with creating(self.path):
            self.path.mkdir(parents=True)

    def write_messages(self, messages: Iterable[Message]) -> None:
        """Keep messages that belong together, or write them during a snapshot; RecordingError if the disk refuses."""
        together = [message.packed() for message in messages]
        if not together:
            return
        self._end_ns = max(self._end_ns, *(message.end_ns for message in together))
        if self._bag is None:
            self._kept.append(together)
            self._forget(self._settings.snapshot_duration * SECOND_NS + LATE_NS, self._end_ns)
        else:
            self._write(self._bag, together)
        for impact in (message for message in together if message.kind == IMPACT):
            if self._bag is None:
                self._bag = self._begin(impact.fields["step"], impact.stamp_ns)
                self._until_ns = self._end_ns + round(self._settings.snapshot_after * SECOND_NS)
        if self._bag is not None and self._end_ns >= self._until_ns:
            self._finish()

    def snapshot(self) -> Path:
        """Write the messages that are kept, and return the path of the bag; during a snapshot, return the path of that.

        Raises InputError if there is no sample since the last snapshot, RecordingError if the disk refuses.
        """
        if self._bag is not None:
            return self._bag.path
        steps = [message.fields["first_step"] + message.fields["samples"] - 1 for message in self._counted()]
        if not steps:
            raise InputError("no sample has been recorded since the last snapshot: try again later")
        self._bag = self._begin(steps[-1], self._end_ns)
        path = self._bag.path
        self._finish()
        return path

    def gap(self, note: str) -> None:
        """End the current snapshot, and discard what is kept: no snapshot has a gap."""
        self.close()
        self._forget(0, self._end_ns)

    def split(self) -> Path:
        """Raise InputError: each snapshot is a bag of its own."""
        raise InputError(f"{self.path} holds snapshots, each a bag of its own: there is nothing to split")

    def sync(self) -> None:
        """Wait until the current snapshot is on the disk; RecordingError if the disk refuses."""
        if self._bag is not None:
            self._bag.sync()

    def close(self, *, sync: bool = False) -> None:
        """Finish the current snapshot, if there is one, and wait for the disk; RecordingError if it refuses."""
        if self._bag is not None:
            self._finish()

    def remove_if_empty(self) -> None:
        """Remove a folder without snapshots."""
        if not any(self.path.iterdir()):
            self.path.rmdir()

    def _counted(self) -> list[Message]:
        return [message for together in self._kept for message in together if "samples" in message.fields]

    def _forget(self, span_ns: float, end_ns: int) -> None:
        """Discard messages that end more than a time before ``end_ns``."""
        while self._kept and max(message.end_ns for message in self._kept[0]) <= end_ns - span_ns:
            self._pass(self._kept.popleft())

    def _pass(self, together: Iterable[Message]) -> None:
        """Note states among messages before those that are kept: the next snapshot begins with the latest."""
        for message in together:
            if message.kind == STATE:
                self._state, of = message, message.fields
                self._info = self._info.with_input(Input(of["revision"], of["first_step"], of["scenario"]))

    def _begin(self, step: int, at_ns: int) -> BagWriter:
        """A snapshot with all messages that are kept from ``snapshot_duration`` before ``at_ns`` on."""
        self._forget(self._settings.snapshot_duration * SECOND_NS, at_ns)
        path = self.path / f"{self.path.name}_step_{step}"
        single = dataclasses.replace(self._settings, max_total_size=0)
        where = {"start_ns": self.start_ns, "prefix": self._prefix, "settings": single, "state": self._state}
        try:
            bag = BagWriter(path, self._info, **where)  # type: ignore[arg-type]
        except InputError as refusal:
            raise RecordingError(str(refusal)) from None
        while self._kept:
            self._write(bag, self._kept.popleft())
        return bag

    def _write(self, bag: BagWriter, together: Sequence[Message]) -> None:
        bag.write_messages(together)
        self._pass(together)
        while self._taken and 0 < self._settings.max_total_size < bag.bound + sum(old.bound for old in self._taken):
            self._taken.pop(0).remove()

    def _finish(self) -> None:
        bag, self._bag = self._bag, None
        if bag is not None:
            self._taken.append(bag)
            bag.close(sync=True)  # it is seldom, and what it holds does not come again


def writer_of(
    path: Path, info: RunInfo, settings: RecordSettings, *, start_ns: int, prefix: str = PREFIX
) -> BagWriter | SnapshotWriter:
    """Writer for the mode in ``settings``; raises InputError if ``path`` exists or cannot be written."""
    if settings.mode == SNAPSHOT:
        return SnapshotWriter(path, info, start_ns=start_ns, prefix=prefix, settings=settings)
    return BagWriter(path, info, start_ns=start_ns, prefix=prefix, settings=settings)
