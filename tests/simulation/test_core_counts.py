"""Results do not depend on how many cores a machine has, nor on how a run is cut: models built afresh, too."""

import os
import subprocess
import sys
import threading

import pytest
from threadpoolctl import threadpool_info

from wheelset_track_sim.runtime.one_core import on_one_core, one_core

RUN = """
import dataclasses, hashlib, os, sys
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: int(sys.argv[1])])
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from threadpoolctl import threadpool_info

chunk, forces, stresses = int(sys.argv[2]), hashlib.sha256(), hashlib.sha256()
print(max(library["num_threads"] for library in threadpool_info()))
simulator = Simulator(load_scenario("damage_wheel_1"))
for end in (2000, 2500):
    while simulator.next_step < end:
        block = simulator.advance(min(chunk, end - simulator.next_step))
        forces.update(block.forces.tobytes())
        stresses.update(block.stresses.tobytes())
    simulator.apply(dataclasses.replace(simulator.scenario, speed=30.0))
print(forces.hexdigest() + stresses.hexdigest())
"""


def digest_with(cores: int, chunk: int, folder: str) -> str:
    env = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    env |= {"WHEELSET_TRACK_SIM_CACHE": folder, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", RUN, str(cores), str(chunk)]
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    threads, digest = done.stdout.split()
    assert int(threads) == cores
    return digest


@pytest.mark.slow
@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="this machine has one core")
def test_one_core_and_two_give_the_same_bits(tmp_path):
    one = digest_with(1, 1389, str(tmp_path / "one"))
    two = digest_with(2, 37, str(tmp_path / "two"))
    assert one == two


def threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_the_limit_holds_until_the_last_thread_is_out():
    before = threads()
    inside, leave = threading.Event(), threading.Event()

    @on_one_core
    def work() -> None:
        inside.set()
        leave.wait()

    other = threading.Thread(target=work)
    other.start()
    inside.wait()
    with one_core():
        both = threads()
    one = threads()
    leave.set()
    other.join()
    assert (both, one, threads()) == ({1}, {1}, before)
