"""From the command to the first chunk of 50 ms: everything cached, no models, and nothing cached at all."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.conftest import Measure

FIRST_CHUNK = """
import time
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
assert len(Simulator(load_scenario("damage_wheel_1")).advance(1389)) == 1389
"""


def first_chunk(**environment: str) -> None:
    """Start a process that ends when it has its first chunk."""
    subprocess.run([sys.executable, "-c", FIRST_CHUNK], env=os.environ | environment, check=True)


@pytest.mark.benchmark(group="start")
def test_warm(measure: Measure) -> None:
    """On one core, as is everything in the table of goals; but see the next two."""
    measure(first_chunk, rounds=5)


@pytest.mark.all_cores
@pytest.mark.benchmark(group="start")
def test_without_models(record: Measure, tmp_path: Path) -> None:
    """Models and tables are built; kernels are compiled already, once for an installation."""
    first_chunk()
    record(lambda: timed(WHEELSET_TRACK_SIM_CACHE=str(tmp_path)))


@pytest.mark.benchmark(group="start")
@pytest.mark.parametrize("cores", ["one core", pytest.param("all cores", marks=pytest.mark.all_cores)])
def test_with_nothing(record: Measure, tmp_path: Path, cores: str) -> None:
    """Models are built and kernels compiled, at the same time where there are cores for it."""
    cold = {"WHEELSET_TRACK_SIM_CACHE": str(tmp_path / "models"), "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    record(lambda: timed(**cold))


def timed(**environment: str) -> dict[str, float]:
    """Elapsed time of a start."""
    start = time.perf_counter()
    first_chunk(**environment)
    return {"seconds": time.perf_counter() - start}
