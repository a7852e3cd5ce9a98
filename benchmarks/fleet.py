"""How many wheelsets run in real time on this machine: ``python benchmarks/fleet.py [CORES]``.

Each runs at 100 km/h with a defect on a wheel, eighteen stresses and full-rate output, on as many cores as said (2). A
count in real time is the simulated time of all wheelsets over the elapsed time, running as fast as possible: so many
would keep pace if nothing were lost by pacing. ``keeps_pace`` then runs a fleet at the clock and says how far it lags.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from wheelset_track_sim.cli.run import CHUNK
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.fleet import Fleet

SCENARIO = "damage_wheel_1"
CORES = 2


def library(wheelsets: int, *, threads: int = CORES, chunks: int = 20, rounds: int = 5) -> float:
    """Wheelsets in real time by ``Fleet``, in memory, with ``threads`` threads: the best of some rounds."""
    with Fleet([load_scenario(SCENARIO)] * wheelsets, threads=threads) as fleet:
        fleet.advance(CHUNK)
        simulated = chunks * CHUNK * fleet.simulators[0].step_period
        return max(wheelsets * simulated / _elapsed(fleet, chunks) for _ in range(rounds))


def library_cost(wheelsets: Sequence[int], *, chunks: int = 20, rounds: int = 10) -> list[float]:
    """Processor time for N wheelsets over N times that of one, on one thread, for each N: 1 if cost is linear."""
    fleets = [Fleet([load_scenario(SCENARIO)] * count, threads=1) for count in (1, *wheelsets)]
    for fleet in fleets:
        fleet.advance(CHUNK)
    # In turns, so that whatever else the machine does befalls all of them.
    times = [[_elapsed(fleet, chunks, time.process_time) for fleet in fleets] for _ in range(rounds)]
    one, *many = (min(column) for column in zip(*times, strict=True))
    return [found / (count * one) for count, found in zip(wheelsets, many, strict=True)]


def nodes(
    wheelsets: int, *, processes: int = 1, cores: int = CORES, record: str = "", span: tuple[float, float] = (2.0, 22.0)
) -> float:
    """Wheelsets in real time by nodes that publish everything, ``wheelsets`` in each of some processes.

    By the difference of two durations, s, so that the start does not count. ``record`` is a folder for bags, or empty.
    """
    short, long = (_processes(wheelsets, processes, cores, duration, record) for duration in span)
    return wheelsets * processes * (span[1] - span[0]) / (long - short)


def node_cost(
    wheelsets: int,
    *,
    cores: int = CORES,
    parameters: Mapping[str, Any] | None = None,
    span: tuple[float, float] = (2.0, 32.0),
) -> float:
    """Share of a core that each wheelset of one process takes in real time: processor time over simulated time."""

    def spent(duration: float) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        given = {"duration": duration, "real_time_factor": 0.0, **(parameters or {})}
        assert _start(wheelsets, cores, given).wait() == 0
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    short, long = map(spent, span)
    return (long - short) / (span[1] - span[0]) / wheelsets


def keeps_pace(
    wheelsets: int, *, cores: int = CORES, seconds: float = 20.0, parameters: Mapping[str, Any] | None = None
) -> float:
    """Largest lag, s, of a fleet in one process at the clock's pace, once it runs; less than a chunk is in time.

    Another process listens to the summaries, in which the nodes say how they keep time.
    """
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from wheelset_track_msgs.msg import LoadSummary

    environment = _environment()
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(environment["ROS_DOMAIN_ID"]))
    listener = rclpy.create_node("listener", context=context)
    lags: list[tuple[float, float]] = []
    for name in (f"wheelset_{number + 1}" for number in range(wheelsets)):
        listener.create_subscription(
            LoadSummary, f"/{name}/summary", lambda told: lags.append((told.time, told.lag)), 100
        )
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(listener)
    done = threading.Event()

    def listen() -> None:
        while not done.is_set():
            executor.spin_once(timeout_sec=0.2)

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        given = {"duration": seconds, "real_time_factor": 1.0, **(parameters or {})}
        assert _start(wheelsets, cores, given, environment).wait() == 0
    finally:
        done.set()
        thread.join()
        executor.shutdown()
        listener.destroy_node()
        context.shutdown()
    return max(lag for at, lag in lags if at > seconds / 2)


def _elapsed(fleet: Fleet, chunks: int, clock: Callable[[], float] = time.perf_counter) -> float:
    started = clock()
    for _ in range(chunks):
        fleet.advance(CHUNK)
    return clock() - started


def _processes(wheelsets: int, processes: int, cores: int, duration: float, record: str) -> float:
    given = {"duration": duration, "real_time_factor": 0.0}
    if record:
        given |= {"record.on_start": "true"}
    started = time.perf_counter()
    running = [
        _start(wheelsets, cores, given | ({"record.directory": f"{record}/{duration}_{number}"} if record else {}))
        for number in range(processes)
    ]
    assert [process.wait() for process in running] == [0] * processes
    return time.perf_counter() - started


def _start(
    wheelsets: int, cores: int, parameters: Mapping[str, Any], environment: Mapping[str, str] | None = None
) -> subprocess.Popen[bytes]:
    command = ["taskset", "-c", f"0-{cores - 1}", sys.executable, "-m", "wheelset_track_sim", "node"]
    command += ["--fleet", str(wheelsets), "--ros-args", "--log-level", "warn", "-p", f"scenario:={SCENARIO}"]
    command += [item for name, value in parameters.items() for item in ("-p", f"{name}:={value}")]
    return subprocess.Popen(command, env=environment or _environment(), stderr=subprocess.DEVNULL)


def _environment() -> dict[str, str]:
    return os.environ | {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(os.getpid() % 90 + 5),
        "OMP_NUM_THREADS": "1",
    }


def main(cores: int = CORES) -> None:
    """Measure and print all of it."""
    for count, ratio in zip((2, 8, 32), library_cost((2, 8, 32)), strict=True):
        print(f"library: time for {count} wheelsets over {count} times that for 1: {ratio:.3f}")
    for count in (1, 2, 8, 32):
        print(f"library, fleet of {count}, {cores} threads: {library(count, threads=cores):.0f} in real time")
    decimated = {"contact_forces.decimation": 10, "axle_stress.decimation": 10}
    for count in (1, 8):
        for what, parameters in (("full rate", {}), ("decimation 10", decimated)):
            cost = node_cost(count, cores=cores, parameters=parameters)
            print(f"node, fleet of {count}, {what}: each takes {100 * cost:.1f} % of a core in real time")
    for count in (1, 2, 8):
        print(f"node, fleet of {count} in one process, {cores} cores: {nodes(count, cores=cores):.1f} in real time")
    found = nodes(4, processes=cores, cores=cores)
    print(f"node, fleets of 4 in {cores} processes, {cores} cores: {found:.1f} in real time")
    for count in (8, 16, 24):
        lag = keeps_pace(count, cores=cores)
        print(f"node, fleet of {count} at the clock's pace: lags {1e3 * lag:.0f} ms at most")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
