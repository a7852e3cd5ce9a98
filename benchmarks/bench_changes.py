"""Starts and live changes by the time of the processor, which other programs on the machine do not change."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from typing import Any

import pytest

from benchmarks.bench_start import FIRST_CHUNK
from benchmarks.conftest import Measure, group
from wheelset_track_sim.irregularities.listing import listed
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

KINDS = {
    "flat": "{type: flat, on: wheel_1, length: 0.04N}",
    "polygon": "{type: polygon, on: wheel_1, harmonics: [{order: 3, amplitude: 5.0Ne-5}]}",
    "roughness of a tread": "{type: roughness, on: wheel_1, seed: N}",
    "corrugation": "{type: corrugation, on: rail_1, wavelength: 0.06, amplitude: 2.0Ne-5}",
    "roughness of both rails": "{type: roughness, on: rail_1, seed: N}, {type: roughness, on: rail_2, seed: 1N}",
    "roughness of four surfaces": ", ".join(
        f"{{type: roughness, on: {surface}, seed: {place}N}}"
        for place, surface in enumerate(("wheel_1", "wheel_2", "rail_1", "rail_2"))
    ),
}
"""Irregularities with a digit N that differs in every round: what was there before is known, and answers at once."""
STARTS = {"import": "import wheelset_track_sim.simulation.simulator", "first chunk": FIRST_CHUNK}


def start(code: str, rounds: int = 5) -> dict[str, float]:
    """Least time of the processor in a process of its own that executes ``code``, s, less that of an empty one."""

    def used(executed: str) -> float:
        before = os.times()
        subprocess.run([sys.executable, "-c", executed], check=True)
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    found = [(used(code), used("")) for _ in range(rounds + 1)][1:]
    return {"processor_s": min(each for each, _ in found) - min(empty for _, empty in found)}


def change(kind: str, rounds: int = 5) -> dict[str, Any]:
    """Least time of the processor, s, in which a running simulator accepts irregularities, then none again."""
    simulator = Simulator(load_scenario("undamaged"))
    simulator.advance(100)
    best = float("inf")
    for round_ in range(rounds + 1):
        new = listed(f"[{KINDS[kind].replace('N', str(round_))}]", str)
        for irregularities in (tuple(new), ()):
            wanted = dataclasses.replace(simulator.scenario, irregularities=irregularities)
            begun = time.process_time()
            revision = simulator.apply(wanted)
            if irregularities and round_:
                best = min(best, time.process_time() - begun)
            while simulator.revision < revision.number:
                simulator.advance(1389)
    return {"processor_s": best}


@pytest.mark.benchmark(group="start")
@pytest.mark.parametrize("what", STARTS)
def test_start(record: Measure, what: str) -> None:
    record(lambda: start(STARTS[what]), what=what)


@group("changes")
@pytest.mark.parametrize("kind", KINDS)
def test_change(record: Measure, kind: str) -> None:
    record(lambda: change(kind), kind=kind)
