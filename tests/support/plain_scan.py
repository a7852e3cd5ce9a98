"""What the MCAP library finds in a file that nobody has finished, record by record."""

import numpy as np
from mcap.exceptions import EndOfFile
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from wheelset_track_sim.bags import RunInfo
from wheelset_track_sim.bags.definitions import deserialise

LARGEST_LOSS = 1.0
"""What a kill may cost of a run at real time, s of simulated time."""


class Scan:
    """What is in the whole records of a bag, chunk by chunk against its checksum."""

    def __init__(self, bag):
        files = [bag] if bag.is_file() else sorted(bag.glob("*.mcap"), key=lambda file: int(file.stem.split("_")[-1]))
        self.infos, self.first, self.forces, self.states = [], [], [], []
        for file in files:
            self._scan(file)
        self.steps = np.concatenate(
            [message.first_step + np.arange(len(message.wheel_1)) for message in self.forces] or [np.zeros(0)]
        )
        last = self.forces[-1] if self.forces else None
        self.end = last.time + len(last.wheel_1) * last.step_period if last else 0.0

    def _scan(self, file):
        schemas, channels, first = {}, {}, None
        with file.open("rb") as stream:
            records = StreamReader(stream, validate_crcs=True).records
            while True:
                try:
                    record = next(records)
                except (EndOfFile, StopIteration):
                    break
                if isinstance(record, Metadata):
                    self.infos.append(RunInfo.from_metadata(record.metadata))
                elif isinstance(record, Schema):
                    schemas[record.id] = record.name.rpartition("/")[2]
                elif isinstance(record, Channel):
                    channels[record.id] = schemas[record.schema_id]
                elif isinstance(record, Message):
                    kind = channels[record.channel_id]
                    first = first or kind
                    if kind in ("ContactForces", "SimulationState"):
                        found = self.forces if kind == "ContactForces" else self.states
                        found.append(deserialise(kind, record.data))
        self.first.append(first)
