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
from pathlib import Path

from wheelset_track_sim.recording.definitions import deserialise

SUBSCRIBER = """
import rclpy, sys, time
from rclpy.qos import QoSProfile
from wheelset_track_msgs.msg import AxleStress, ContactForces, LoadSummary
rclpy.init()
node = rclpy.create_node("subscriber")
topics = {"contact_forces": ContactForces, "summary": LoadSummary}
topics |= {f"axle_stress/{name}": AxleStress for name in ("a1", "b1", "c1")}
for topic, kind in topics.items():
    node.create_subscription(kind, f"/wheelset_track_sim/{topic}", lambda message: None, QoSProfile(depth=500))
print("ready", flush=True)
rclpy.spin(node)
"""


def node_throughput(
    seconds: float = 30.0,
    *,
    subscriber: bool = False,
    record: bool = True,
    scenario: str = "damage_wheel_1",
    core: int = 0,
) -> dict[str, float]:
    """Real-time factor of a node from its second chunk on, and the elapsed time of start and first chunk, s."""
    environment = os.environ | {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(os.getpid() % 90 + 5),
    }
    with tempfile.TemporaryDirectory() as folder:
        parameters = {
            "scenario": scenario,
            "real_time_factor": 0.0,
            "duration": seconds,
            "record.on_start": str(record).lower(),
            "record.directory": folder,
            "record.name": "bag",
        }
        command = [sys.executable, "-m", "wheelset_track_sim", "node", "--ros-args"]
        command += [item for name, value in parameters.items() for item in ("-p", f"{name}:={value}")]
        if hasattr(os, "sched_setaffinity"):
            command = ["taskset", "-c", str(core), *command]
        listening = None
        if subscriber:
            listening = subprocess.Popen([sys.executable, "-c", SUBSCRIBER], env=environment, stdout=subprocess.PIPE)
            assert listening.stdout is not None
            listening.stdout.readline()
        started = time.time()
        try:
            subprocess.run(command, env=environment, check=True, stderr=subprocess.DEVNULL)
        finally:
            ended = time.time()
            if listening is not None:
                listening.terminate()
                listening.wait()
        return {"whole": seconds / (ended - started)} | (_account(Path(folder) / "bag", started) if record else {})


def _account(bag: Path, started: float) -> dict[str, float]:
    """Real-time factor, and time from the start to the first stamp, s, by what the node says in its bag."""
    from mcap.reader import make_reader

    with (bag / "bag_0.mcap").open("rb") as stream:
        summaries = [
            deserialise("LoadSummary", message.data)
            for *_, message in make_reader(stream).iter_messages(["/wheelset_track_sim/summary"])
        ]
    spans = [summary.samples * summary.step_period for summary in summaries]
    elapsed = [span / summary.real_time_factor for span, summary in zip(spans, summaries, strict=True)]
    stamp = summaries[0].header.stamp
    return {
        "real_time_factor": sum(spans[1:]) / sum(elapsed[1:]),
        "fastest_second": max(
            sum(spans[first : first + 20]) / sum(elapsed[first : first + 20]) for first in range(1, len(spans) - 20)
        ),
        "start_s": stamp.sec + 1e-9 * stamp.nanosec - started,
        "first_chunk_s": elapsed[0],
    }


if __name__ == "__main__":
    for listens in (False, True):
        found = node_throughput(*map(float, sys.argv[1:2]), subscriber=listens)
        print(
            "with a subscriber" if listens else "without subscribers", {name: round(x, 2) for name, x in found.items()}
        )
