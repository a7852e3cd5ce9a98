"""How fast a run is written to a bag and read back: ``python benchmarks/bag_throughput.py [SECONDS] [SPEED_KMH]``.

The signals are smooth sums of sines with all eighteen stress components busy, at the sampling rate of a speed and 1 mm
steps. Times are those of the processor, so that other programs on the machine do not count.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from wheelset_track_sim.recording import BagWriter, RunInfo, blocks
from wheelset_track_sim.simulation.block import SampleBlock

DX, CHUNK = 1e-3, 0.05


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


def bag_throughput(seconds: float = 20.0, kmh: float = 100.0) -> dict[str, float]:
    """Real-time factors of writing and reading, and the size of the bag, bytes."""
    made = signals(seconds, kmh / 3.6)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        with BagWriter(path, RunInfo("benchmark", "", "", 0.6), start_ns=0) as bag:
            bag.write(made[0])  # types and libraries load with the first block
            start = time.process_time()
            for block in made[1:]:
                bag.write(block)
            bag.close()
            written = time.process_time() - start
        size = path.stat().st_size
        start = time.process_time()
        count = sum(len(block) for block in blocks(path))
        read = time.process_time() - start
    assert count == sum(map(len, made))
    numbers = sum(block.forces.nbytes + block.stresses.nbytes for block in made)
    return {"write": seconds / written, "read": seconds / read, "bytes": size, "bytes_of_numbers": numbers}


if __name__ == "__main__":
    found = bag_throughput(*map(float, sys.argv[1:]))
    print(f"{found['bytes_of_numbers'] / 1e6:.0f} MB of numbers, bag {found['bytes'] / 1e6:.0f} MB")
    print(f"write {found['write']:.0f} x real time, read {found['read']:.0f} x real time")
