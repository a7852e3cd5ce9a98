"""Resident memory over a long run: ``python benchmarks/memory.py [SECONDS]``, an hour of simulated time by default.

``run`` in memory, the node publishing everything, and ``run --out`` for a tenth of the time, whose bag takes 4 MB a
simulated second. Each is a process of its own, as fast as possible; its memory is read ten times a second.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

MEGABYTE = 1 << 20


@dataclass(frozen=True)
class Memory:
    """Resident memory of a process that simulates at an even pace, once it simulates."""

    simulated: float
    """s"""
    resident: list[float]
    """MB, at even intervals."""

    def after(self, seconds: float) -> list[float]:
        """From ``seconds`` of simulated time on, MB."""
        return self.resident[int(len(self.resident) * seconds / self.simulated) :]

    @property
    def spread(self) -> float:
        """Largest over smallest after the first minute, or the first tenth of a short run, less one."""
        later = self.after(min(60.0, self.simulated / 10))
        return max(later) / min(later) - 1


def memory_of(command: Sequence[str], simulated: float) -> Memory:
    """Memory of ``wheelset-track-sim`` with the arguments ``command`` from its first two seconds on to its end."""
    environment = os.environ | {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(os.getpid() % 90 + 5),
    }
    process = subprocess.Popen(
        [sys.executable, "-m", "wheelset_track_sim", *command],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    statm = Path(f"/proc/{process.pid}/statm")
    found = []
    while process.poll() is None:
        try:
            found.append(int(statm.read_text().split()[1]) * os.sysconf("SC_PAGESIZE") / MEGABYTE)
        except (FileNotFoundError, ProcessLookupError, IndexError):
            break
        time.sleep(0.1)
    if process.wait() != 0:
        raise RuntimeError(f"{command} ended with status {process.returncode}")
    return Memory(simulated, found[20:-10])  # it starts up, and in the end takes itself down


def memory_of_run(seconds: float, out: Path | None = None, scenario: str = "damage_wheel_1") -> Memory:
    """Memory of ``run``."""
    recorded = [] if out is None else ["--out", str(out)]
    return memory_of(["run", scenario, "--duration", str(seconds), "--json", *recorded], seconds)


def memory_of_node(seconds: float) -> Memory:
    """Memory of the node at its full speed, with nobody listening."""
    parameters = {"duration": float(seconds), "real_time_factor": 0.0}
    given = [item for name, value in parameters.items() for item in ("-p", f"{name}:={value}")]
    return memory_of(["node", "--ros-args", *given], seconds)


def main(seconds: float = 3600.0) -> None:
    """Measure all and print."""
    with tempfile.TemporaryDirectory() as folder:
        for name, measure in (
            ("run", lambda: memory_of_run(seconds)),
            ("run of rough wheels", lambda: memory_of_run(seconds, scenario="rough_wheel")),
            ("node", lambda: memory_of_node(seconds)),
            ("run --out, a tenth of the time", lambda: memory_of_run(seconds / 10, Path(folder) / "run.mcap")),
        ):
            found = measure()
            tenths = [found.resident[len(found.resident) * part // 10] for part in range(10)] + found.resident[-1:]
            print(
                f"{name}: " + " ".join(f"{value:.0f}" for value in tenths) + f" MB, spread {100 * found.spread:.1f} %"
            )


if __name__ == "__main__":
    main(*map(float, sys.argv[1:2]))
