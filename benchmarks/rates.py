"""What rates of messages cost in real time: ``python benchmarks/rates.py``.

A node publishes chunks of 100, 50 and 10 ms, which are 10, 20 and 100 messages a second on each topic, at full rate and
decimated; a subscriber in a process of its own takes in one topic. Shares of a core are times of the processor over
simulated time, from the difference of two durations, so that starts do not count.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time

from benchmarks.fleet import SCENARIO, node_cost

CHUNKS = {10: 0.1, 20: 0.05, 100: 0.01}
"""Messages a second: chunk, s."""
SUBSCRIBER = """
import rclpy, sys
from rclpy.executors import ExternalShutdownException
from rclpy.qos import QoSProfile
from wheelset_track_msgs import msg
rclpy.init()
node = rclpy.create_node("listener")
kind, depth = getattr(msg, sys.argv[2]), QoSProfile(depth=50)
node.create_subscription(kind, f"/wheelset_track_sim/{sys.argv[1]}", lambda message: None, depth)
print("ready", flush=True)
try:
    rclpy.spin(node)
except ExternalShutdownException:
    pass
"""


def subscriber_cost(topic: str, kind: str, chunk: float, *, seconds: float = 15.0) -> float:
    """Share of a core that a subscriber in rclpy takes in real time, once the stream runs."""
    environment = os.environ | {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(os.getpid() % 90 + 5),
    }
    given = {"scenario": SCENARIO, "chunk_duration": chunk}
    command = [sys.executable, "-m", "wheelset_track_sim", "node", "--ros-args", "--log-level", "warn"]
    command += [item for name, value in given.items() for item in ("-p", f"{name}:={value}")]
    node = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    listening = subprocess.Popen(
        [sys.executable, "-c", SUBSCRIBER, topic, kind], env=environment, stdout=subprocess.PIPE
    )
    try:
        assert listening.stdout is not None
        listening.stdout.readline()
        time.sleep(15.0)  # the node starts
        before, began = _used(listening.pid), time.monotonic()
        time.sleep(seconds)
        return (_used(listening.pid) - before) / (time.monotonic() - began)
    finally:
        node.terminate()
        node.wait()
        listening.kill()
        listening.wait()


def _used(pid: int) -> float:
    """Time of the processor that a process has used, s."""
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:  # noqa: PTH123  a path of the system
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure and print all of it."""
    for rate, chunk in CHUNKS.items():
        for what, decimation in (("full rate", 1), ("decimation 10", 10)):
            parameters = {"chunk_duration": chunk}
            parameters |= dict.fromkeys(("contact_forces.decimation", "axle_stress.decimation"), decimation)
            cost = node_cost(1, parameters=parameters)
            print(f"node, {rate} messages a second, {what}: {100 * cost:.1f} % of a core", flush=True)
    for rate, chunk in CHUNKS.items():
        for topic, kind in (
            ("summary", "LoadSummary"),
            ("contact_forces", "ContactForces"),
            ("axle_stress/a1", "AxleStress"),
        ):
            cost = subscriber_cost(topic, kind, chunk)
            print(f"subscriber, {rate} messages a second of {topic}: {100 * cost:.1f} % of a core", flush=True)


if __name__ == "__main__":
    main()
