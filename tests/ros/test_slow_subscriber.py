"""Subscribers that do not keep up: simulation, recorder and other subscribers do not wait for them."""

import os
import signal
import statistics
import subprocess
import sys
from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import pytest

from wheelset_track_sim.bags import read_bag

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

TOPICS = {"contact_forces": "ContactForces", "axle_stress/a1": "AxleStress", "summary": "LoadSummary"}
SUBSCRIBER = f"""
import time
import rclpy
import wheelset_track_msgs.msg
from rclpy.qos import HistoryPolicy, QoSProfile

def take(message):
    print("taken", flush=True)
    time.sleep(PAUSE)

rclpy.init()
node = rclpy.create_node("slow")
everything = QoSProfile(history=HistoryPolicy.KEEP_ALL)  # reliable: the worst a publisher can meet
for topic, kind in {TOPICS}.items():
    node.create_subscription(getattr(wheelset_track_msgs.msg, kind), f"/wheelset_track_sim/{{topic}}", take, everything)
rclpy.spin(node)
"""
CHUNKS = 200


@contextmanager
def subscriber(domain, pause):
    """A process that takes every message and then sleeps."""
    environment = os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-c", SUBSCRIBER.replace("PAUSE", str(pause))]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True, start_new_session=True)
    try:
        assert process.stdout.readline() == "taken\n"
        yield process
    finally:
        process.send_signal(signal.SIGCONT)
        process.terminate()
        process.communicate()


def pace(client, summaries, times=1):
    """Best of the median real time factors of some stretches of coming chunks: others use this machine, too."""
    found = []
    for _ in range(times):
        seen = len(summaries)
        client.until(lambda seen=seen: len(summaries) >= seen + CHUNKS)
        found.append(statistics.median(summary.real_time_factor for summary in summaries[seen:]))
    return max(found)


@pytest.mark.parametrize("stopped", [False, True], ids=["slow", "stopped"])
def test_nobody_waits_for_a_subscriber(start, client, domain, tmp_path, stopped):
    summaries = client.collect("summary", "LoadSummary")
    bag = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="undamaged", real_time_factor=0.0, **bag)
    client.until(lambda: summaries)
    alone = pace(client, summaries)
    with subscriber(domain, pause=0.5) as process:
        if stopped:
            process.send_signal(signal.SIGSTOP)
        assert pace(client, summaries, times=6) > alone / 2
        # Now at a pace at which the history of the publishers is a second and who keeps up gets all.
        assert client.set(real_time_factor=2.0).successful
        client.until(lambda: summaries[-1].real_time_factor < alone / 2)
        seen = len(summaries)
        client.until(lambda: len(summaries) >= seen + CHUNKS)
    for before, after in pairwise(summaries[seen:]):
        assert after.first_step == before.first_step + before.samples
    assert node.signal(signal.SIGINT) == 0, node.errors
    recorded = read_bag(tmp_path / "run")
    np.testing.assert_array_equal(np.diff(recorded.steps), 1)
    assert recorded.steps[0] == 0
    assert len(recorded) >= summaries[-1].first_step + summaries[-1].samples
