"""What a bag holds by the MCAP library and the definitions in the bag: counted without the code that it checks."""

from collections import Counter
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Channel, DataEnd, Message, Schema
from mcap.stream_reader import StreamReader
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FORCES, STRESS = "wheelset_track_msgs/msg/ContactForces", "wheelset_track_msgs/msg/AxleStress"
SIGNALS = {FORCES: ("wheel_1", "wheel_2"), STRESS: ("xx", "yy", "zz", "xy", "xz", "yz")}


class Span(NamedTuple):
    """Consecutive samples of a signal."""

    first: int
    end: int
    factor: int
    """Steps from sample to sample."""
    values: np.ndarray[Any, Any]
    """(samples, components)"""


class PlainSignals:
    """All messages of a bag, counted by topic, and the samples of each signal in the order of their steps."""

    def __init__(self, path: Path) -> None:
        self.counts: Counter[str] = Counter()
        self.spans: dict[str, list[Span]] = {}
        for file in [path] if path.is_file() else sorted(path.glob("*.mcap")):
            self._scan(file)
        for spans in self.spans.values():
            spans.sort(key=lambda span: span.first)

    @property
    def decimated(self) -> bool:
        return any(span.factor != 1 for spans in self.spans.values() for span in spans)

    def assert_whole(self) -> None:
        """Every signal has finite samples at each of its steps from first to last; at the same ones, if at all."""
        for spans in self.spans.values():
            for before, after in pairwise(spans):
                assert (before.end, before.factor) == (after.first, after.factor)
            assert all(np.isfinite(span.values).all() for span in spans)
        if not self.decimated:
            assert len({(spans[0].first, spans[-1].end) for spans in self.spans.values()}) <= 1

    def _scan(self, file: Path) -> None:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        with file.open("rb") as stream, suppress(Exception):  # the end may repeat what is missing before
            for record in StreamReader(stream).records:
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
        with file.open("rb") as stream:
            for record in StreamReader(stream).records:
                if isinstance(record, DataEnd):
                    return
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    channels[record.id] = record
                elif isinstance(record, Message):
                    channel = channels[record.channel_id]
                    self.counts[channel.topic] += 1
                    schema = schemas[channel.schema_id]
                    if schema.name in SIGNALS:
                        # Without samples that cannot be read a signal has a gap; a topic of another name may hold them.
                        with suppress(SerdeError):
                            span = _span(schema, record.data)
                            self.spans.setdefault(channel.topic, []).append(span)


def _span(schema: Schema, data: bytes) -> Span:
    message = _store(schema.name, schema.data).deserialize_cdr(data, schema.name)
    values = np.stack([getattr(message, name) for name in SIGNALS[schema.name]], axis=-1)
    factor = getattr(message, "decimation", 1)
    return Span(message.first_step, message.first_step + factor * len(values), factor, values)


@lru_cache(maxsize=64)
def _store(name: str, definition: bytes) -> Any:
    store = get_typestore(Stores.ROS2_JAZZY)
    found = get_types_from_msg(definition.decode(), name)
    store.register({each: of for each, of in found.items() if each.startswith("wheelset_track_msgs/")})
    return store
