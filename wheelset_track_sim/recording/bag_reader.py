"""Bags read back as the blocks of samples that were recorded, bit by bit."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap.summary import Summary
from rosbags.serde import SerdeError
from zstandard import ZstdError

from ..errors import RecordingError
from ..simulation.block import SampleBlock
from .definitions import PACKAGE, deserialise
from .messages import State, block_of, start_of, state_of
from .run_info import METADATA_NAME, RunInfo

KINDS = ("ContactForces", "AxleStress", "SimulationState")
"""Messages that make up a run; all others are derived from them."""
DAMAGE = (McapError, SerdeError, ZstdError, struct.error, ValueError, LookupError, MemoryError, OverflowError)
"""What the libraries raise for bytes that are not what they should be."""


@dataclass(frozen=True)
class Bag:
    """A bag that can be read, a file or a folder; topics are found by their types, so the prefix does not matter.

    Bags of ``ros2 bag record`` are read too. Every method raises RecordingError, in one line, if the bag is missing,
    damaged, has gaps or holds no run.
    """

    path: Path

    @cached_property
    def files(self) -> tuple[Path, ...]:
        """Files of the bag in their order."""
        if not self.path.exists():
            raise RecordingError(f"{self.path} does not exist: give a bag folder or an .mcap file")
        if self.path.is_file():
            return (self.path,)
        files = sorted(self.path.glob("*.mcap"), key=lambda file: (_number(file), file.name))
        if not files:
            raise RecordingError(f"{self.path} holds no .mcap file: give a bag folder or an .mcap file")
        return tuple(files)

    @cached_property
    def info(self) -> RunInfo:
        """What the bag says about its run; a bag of ``ros2 bag record`` says what its first state message says."""
        with _reading(self.files[0]) as reader:
            for record in reader.iter_metadata():
                if record.name == METADATA_NAME:
                    return RunInfo.from_metadata(record.metadata)
        for event in self.events():
            if isinstance(event, State):
                return RunInfo(event.scenario_name, event.scenario, event.digest, math.nan, versions={})
        return RunInfo("unknown", "", "", math.nan, versions={})

    @cached_property
    def start_ns(self) -> int:
        """Time stamp of step 0, ns since the epoch."""
        for _, _, message in self._messages():
            return start_of(message)
        raise self._nothing()

    def blocks(self) -> Iterator[SampleBlock]:
        """Blocks of the run in their order, without gaps."""
        return (event for event in self.events() if isinstance(event, SampleBlock))

    def events(self) -> Iterator[SampleBlock | State]:
        """Blocks without gaps, and states where they stand in the bag."""
        nodes = self._stress_topics()
        pending: dict[int, dict[str, Any]] = {}
        following: int | None = None
        for kind, topic, message in self._messages():
            if kind == "SimulationState":
                yield state_of(message)
                continue
            if message.decimation != 1:
                raise RecordingError(
                    f"{self.path} holds only each {message.decimation}th step of {topic}: record it at full rate"
                )
            chunk = pending.setdefault(message.first_step, {})
            chunk[topic if kind == "AxleStress" else "forces"] = message
            if len(chunk) <= len(nodes):
                continue
            block = block_of(chunk["forces"], [chunk[node] for node in nodes])
            del pending[message.first_step]
            if following is not None and block.first_step != following:
                raise RecordingError(
                    f"{self.path} has a gap: after step {following - 1} comes step {block.first_step}, record it again"
                )
            following = block.first_step + len(block)
            yield block
        if following is None:
            raise self._nothing()

    @cached_property
    def states(self) -> tuple[State, ...]:
        """What was simulated: the state at the start, and one for every revision."""
        return tuple(state_of(message) for _, _, message in self._messages(("SimulationState",)))

    def _stress_topics(self) -> list[str]:
        for file in self.files:
            with _reading(file) as reader:
                summary = _summary(reader)
                found = [
                    channel.topic
                    for _, channel in sorted(summary.channels.items())
                    if summary.schemas[channel.schema_id].name == f"{PACKAGE}/msg/AxleStress"
                ]
                if found or "ContactForces" in _topics(summary).values():
                    return found
        return []

    def _messages(self, wanted: Collection[str] = KINDS) -> Iterator[tuple[str, str, Any]]:
        """Short type name, topic and message of the kinds ``wanted``, in the order of the files."""
        for file in self.files:
            with _reading(file) as reader:
                kinds = {topic: kind for topic, kind in _topics(_summary(reader)).items() if kind in wanted}
                if not kinds:
                    continue
                # In the order of time, which is that of the file: without it mcap reads all before it yields the first.
                for _, channel, message in reader.iter_messages(topics=[*kinds]):
                    kind = kinds[channel.topic]
                    yield kind, channel.topic, deserialise(kind, message.data)

    def _nothing(self) -> RecordingError:
        return RecordingError(
            f"{self.path} holds no complete chunk of contact forces and stresses: give a bag of a run"
        )


def _topics(summary: Summary) -> dict[str, str]:
    """Topics that make up a run, with the short names of their types."""
    found = {}
    for channel in summary.channels.values():
        package, _, kind = summary.schemas[channel.schema_id].name.partition("/msg/")
        if package == PACKAGE and kind in KINDS:
            found[channel.topic] = kind
    return found


def _summary(reader: McapReader) -> Summary:
    summary = reader.get_summary()
    if summary is None or (summary.statistics and summary.statistics.message_count and not summary.chunk_indexes):
        raise ValueError("it has no index")
    return summary


@contextmanager
def _reading(file: Path) -> Iterator[McapReader]:
    """Reader of one file, with all that can be wrong with the file as one line."""
    try:
        with file.open("rb") as stream:
            yield make_reader(stream, validate_crcs=True)
    except OSError as reason:
        raise RecordingError(f"{file} cannot be read ({reason.strerror}): give a bag folder or an .mcap file") from None
    except DAMAGE as reason:
        detail = " ".join(str(reason).split()) or type(reason).__name__
        raise RecordingError(
            f"{file} is not a complete bag ({detail}): it is damaged, was not closed, or is another kind of file"
        ) from reason


def _number(file: Path) -> int:
    """Number at the end of a file's name."""
    found = re.search(r"(\d+)$", file.stem)
    return int(found[1]) if found else 0
