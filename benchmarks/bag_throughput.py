"""How fast a run is written to a bag and read back: ``python benchmarks/bag_throughput.py [SECONDS] [SPEED_KMH]``.

The signals are smooth sums of sines with all eighteen stress components busy, at the sampling rate of a speed and 1 mm
steps; they come again after 20 s, so that a bag may be of any length: 600 s are 2.7 GB of numbers. Times are those of
the processor, so that other programs on the machine do not count, and beside them the clock's, which the disk is in.
"""

from __future__ import annotations

import dataclasses
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from wheelset_track_sim.bags import BagWriter, RunInfo, blocks
from wheelset_track_sim.samples.block import SampleBlock

DX, CHUNK, PERIOD = 1e-3, 0.05, 20.0
EVERY = 100
"""Blocks from one look at the memory to the next."""


def signals(seconds: float, speed: float) -> list[SampleBlock]:
    """Blocks of 50 ms at a speed in m/s."""
    rng = np.random.default_rng(1)
    dt = DX / speed
    length = round(CHUNK / dt)
    made = []
    tones = rng.normal(size=(5, 20)), rng.uniform(0, 2 * np.pi, (5, 20))
    for first in range(0, round(seconds / dt), length):
        t = (first + np.arange(length)) * dt
        parts = zip((46, 85, 206, 409, 1919), *tones, strict=True)
        signal = sum(size * np.sin(2 * np.pi * f * t[:, None] + phase) for f, size, phase in parts)
        forces = 98.1e3 + 3e3 * signal[:, :2]
        stresses = 1e6 * np.ascontiguousarray(signal[:, 2:]).reshape(-1, 3, 6)
        made.append(SampleBlock(first, first * dt, dt, speed, first * DX, 0, forces, stresses, ("A1", "B1", "C1")))
    return made


def repeated(made: list[SampleBlock], seconds: float) -> Iterator[SampleBlock]:
    """Blocks one after the other, over and over, until the time is over."""
    first, dt = 0, made[0].step_period
    while True:
        for block in made:
            if first * dt >= seconds:
                return
            # Anew, as a simulator's: what is worked out of a block stays with it.
            yield dataclasses.replace(block, first_step=first, time=first * dt, position=first * DX)
            first += len(block)


def resident() -> float:
    """Memory of this process, MB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / 1e6


class Watched:
    """Blocks as they come, with their number, their bytes, and what memory of this process grows by meanwhile."""

    def __init__(self, source: Iterator[SampleBlock]) -> None:
        self.samples, self.numbers, self.grown = 0, 0, 0.0
        self._source = source

    def __iter__(self) -> Iterator[SampleBlock]:
        before = 0.0
        for number, block in enumerate(self._source):
            yield block
            self.samples += len(block)
            self.numbers += block.forces.nbytes + block.stresses.nbytes
            if number % EVERY == 0:
                before = before or resident()
                self.grown = max(self.grown, resident() - before)


def bag_throughput(seconds: float = 20.0, kmh: float = 100.0) -> dict[str, float]:
    """Real-time factors of writing and reading, the size of the bag, bytes, and what memory grows by, MB."""
    made = signals(min(seconds, PERIOD), kmh / 3.6)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        given = Watched(repeated(made, seconds))
        with BagWriter(path, RunInfo("benchmark", "", "", 0.6), start_ns=0) as bag:
            source = iter(given)
            bag.write(next(source))  # types and libraries load with the first block
            start = time.process_time(), time.perf_counter()
            for block in source:
                bag.write(block)
            bag.close()
            written = time.process_time() - start[0], time.perf_counter() - start[1]
        size = path.stat().st_size
        found = Watched(blocks(path))
        start = time.process_time(), time.perf_counter()
        for _ in found:
            pass
        read = time.process_time() - start[0], time.perf_counter() - start[1]
    assert found.samples == given.samples
    return {
        "write": seconds / written[0],
        "write_by_clock": seconds / written[1],
        "read": seconds / read[0],
        "read_by_clock": seconds / read[1],
        "bytes": size,
        "bytes_of_numbers": given.numbers,
        "grown_writing_mb": given.grown,
        "grown_reading_mb": found.grown,
    }


if __name__ == "__main__":
    found = bag_throughput(*map(float, sys.argv[1:]))
    print(f"{found['bytes_of_numbers'] / 1e6:.0f} MB of numbers, bag {found['bytes'] / 1e6:.0f} MB")
    for name in ("write", "read"):
        print(f"{name} {found[name]:.0f} x real time, {found[f'{name}_by_clock']:.0f} x by the clock")
    print(
        f"memory grows by {found['grown_writing_mb']:.0f} MB in writing, {found['grown_reading_mb']:.0f} MB in reading"
    )
