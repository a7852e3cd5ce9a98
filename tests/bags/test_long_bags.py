"""Long bags: ``benchmarks/bag_throughput.py 600`` is ten minutes, these are half of one."""

import dataclasses
import os
from pathlib import Path

import pytest

from wheelset_track_sim.bags import BagWriter, RecordSettings, blocks

BLOCKS, SAMPLES = 600, 1389
LARGEST_GROWTH = 30e6
"""Memory, bytes; the bag has five times as much."""


def resident():
    """Memory of this process, bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


class Memory:
    """How much more memory there is than in the beginning, looked at now and then."""

    def __init__(self):
        self.first = self.largest = 0

    def look(self, number):
        if number == 40:
            self.first = resident()
        if number >= 40 and number % 20 == 0:
            self.largest = max(self.largest, resident() - self.first)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs what Linux tells of memory")
def test_memory_does_not_grow_with_a_bag(tmp_path, run_info, make_block):
    some = [make_block(SAMPLES * number, SAMPLES) for number in range(20)]
    step_period, writing, reading = some[0].step_period, Memory(), Memory()
    with BagWriter(tmp_path / "run", run_info, start_ns=0, settings=RecordSettings(max_duration=5.0)) as writer:
        for number in range(BLOCKS):
            first = SAMPLES * number
            block = dataclasses.replace(some[number % 20], first_step=first, time=first * step_period)
            writer.write(block)
            writing.look(number)
    size = sum(file.stat().st_size for file in (tmp_path / "run").glob("*.mcap"))
    following = 0
    for number, block in enumerate(blocks(tmp_path / "run")):
        assert block.first_step == following
        assert block.forces[0, 0] == some[number % 20].forces[0, 0]
        following += len(block)
        reading.look(number)
    assert following == BLOCKS * SAMPLES
    assert size > 5 * LARGEST_GROWTH
    assert writing.largest < LARGEST_GROWTH
    assert reading.largest < LARGEST_GROWTH
