"""How fast a node streams, publishing everything and recording: ``python benchmarks/node_throughput.py [SECONDS]``.

The node is a process of its own, as fast as possible and on one core; a subscriber, if there is one, is another process
that takes in every topic, on all cores. The node's own account in the bag says how long each chunk took.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from wheelset_track_sim.bags.definitions import deserialise

SUBSCRIBER = """
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from wheelset_track_msgs.msg import AxleStress, ContactForces, LoadSummary
rclpy.init()
node = rclpy.create_node("subscriber")
topics = {"contact_forces": ContactForces, "summary": LoadSummary}
topics |= {f"axle_stress/{name}": AxleStress for name in ("a1", "b1", "c1")}
for topic, kind in topics.items():
    node.create_subscription(kind, f"/wheelset_track_sim/{topic}", lambda message: None, QoSProfile(depth=500))
print("ready", flush=True)
try:
    rclpy.spin(node)
except ExternalShutdownException:
    pass
"""


def node_throughput(
    seconds: float = 30.0,
    *,
    subscriber: bool = False,
    record: bool = True,
    scenario: str = "damage_wheel_1",
    core: int = 0,
) -> dict[str, float]:
    """Real-time factors of a node, by the clock from its second chunk on and by its own time of the processor.

    With ``record`` also the time from its start to the stamp of its first step, s.
    """
    environment = _environment()
    with ExitStack() as stack:
        if subscriber:
            _subscribe(stack, environment)
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        of_start, _ = _run(environment, 1.0, folder if record else None, "short", scenario, core)
        used, started = _run(environment, seconds, folder if record else None, "long", scenario, core)
        found = {"of_the_processor": (seconds - 1.0) / (used - of_start), "start_of_the_processor_s": of_start}
        return found | (_account(folder / "long", started) if record else {})


def node_load(
    rate: float, subscribers: int, span: tuple[float, float] = (2.0, 12.0), scenario: str = "damage_wheel_1"
) -> float:
    """Share of a core that a node in real time takes, publishing everything in ``rate`` chunks a second.

    It is the difference of two durations, s, so that the start does not count.
    """
    environment = _environment()
    with ExitStack() as stack:
        for _ in range(subscribers):
            _subscribe(stack, environment)
        paced = {"real_time_factor": 1.0, "chunk_duration": 1.0 / rate}
        short, long = (_run(environment, seconds, None, "", scenario, 0, paced)[0] for seconds in span)
    return (long - short) / (span[1] - span[0])


def _environment() -> dict[str, str]:
    return os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(os.getpid() % 90 + 5)}


def _subscribe(stack: ExitStack, environment: dict[str, str]) -> None:
    """A process that takes in every topic, until the stack is unwound."""
    listening = subprocess.Popen([sys.executable, "-c", SUBSCRIBER], env=environment, stdout=subprocess.PIPE)
    stack.enter_context(listening)
    stack.callback(listening.terminate)
    assert listening.stdout is not None
    listening.stdout.readline()


def _run(
    environment: dict[str, str],
    seconds: float,
    folder: Path | None,
    name: str,
    scenario: str,
    core: int,
    pace: Mapping[str, float] | None = None,
) -> tuple[float, float]:
    """Time of the processor that a node uses for ``seconds`` of simulated time, and when it was started, s."""
    parameters: dict[str, object] = {"scenario": scenario, "real_time_factor": 0.0, "duration": float(seconds)}
    parameters |= pace or {}
    if folder is not None:
        parameters |= {"record.on_start": "true", "record.directory": folder, "record.name": name}
    command = [sys.executable, "-m", "wheelset_track_sim", "node", "--ros-args"]
    command += [item for key, value in parameters.items() for item in ("-p", f"{key}:={value}")]
    if hasattr(os, "sched_setaffinity"):
        command = ["taskset", "-c", str(core), *command]
    started = time.time()
    process = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"the node ended with status {process.returncode}")
    return used.ru_utime + used.ru_stime, started


def _account(bag: Path, started: float) -> dict[str, float]:
    """Real-time factor, and time from the start to the first stamp, s, by what the node says in its bag."""
    from mcap.reader import make_reader

    with (bag / f"{bag.name}_0.mcap").open("rb") as stream:
        summaries = [
            deserialise("LoadSummary", message.data)
            for *_, message in make_reader(stream).iter_messages(["/wheelset_track_sim/summary"])
        ]
    spans = [summary.samples * summary.step_period for summary in summaries]
    elapsed = [span / summary.real_time_factor for span, summary in zip(spans, summaries, strict=True)]
    stamp = summaries[0].header.stamp
    return {
        "real_time_factor": sum(spans[1:]) / sum(elapsed[1:]),
        "start_s": stamp.sec + 1e-9 * stamp.nanosec - started,
    }


if __name__ == "__main__":
    for listens in (False, True):
        found = node_throughput(*map(float, sys.argv[1:2]), subscriber=listens)
        print(
            "with a subscriber" if listens else "without subscribers", {name: round(x, 2) for name, x in found.items()}
        )
