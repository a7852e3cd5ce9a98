"""``get``, ``set``, ``call`` and ``echo``: each a process of its own beside a running node."""

import json
import os
import signal
import subprocess
import sys

import pytest

from wheelset_track_sim.inputs.yaml12 import parse

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.fixture
def ask(domain):
    """Run a command; returns exit status, standard output and errors."""
    own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}

    def ask(*arguments):
        command = [sys.executable, "-m", "wheelset_track_sim", *arguments]
        done = subprocess.run(command, env=os.environ | own, capture_output=True, text=True, timeout=300, check=False)
        return done.returncode, done.stdout, done.stderr

    return ask


def test_a_running_node_is_asked_and_changed(start, client, states, ask):
    start(scenario="undamaged", real_time_factor=1.0)
    client.until(lambda: states)

    status, out, errors = ask("get", "scenario", "axle_load", "--json")
    assert (status, json.loads(out), errors) == (0, {"scenario": "undamaged", "axle_load": 196200.0}, "")
    status, out, _ = ask("get")
    assert status == 0
    assert parse(out, "out")["wheel_1.damage.a"] == 0.03

    status, out, errors = ask("set", "speed=108 km/h", "wheel_1.damage.h=1 mm")
    assert (status, errors) == (0, "")
    assert "revision 1" in out
    assert client.get("speed", "wheel_1.damage.h") == [30.0, 0.001]
    status, out, errors = ask("set", "speed=500 km/h")
    assert (status, out) == (2, "")
    assert "speed = 500 km/h, which is 138.889 m/s, is out of range" in errors
    assert ask("set", "chunk_duration=1")[0] == 0  # a whole number for one that need not be whole
    status, _, errors = ask("set", "scenario=trailer")
    assert status == 2
    assert len(errors.splitlines()) == 1
    status, _, errors = ask("get", "sped")
    assert (status, "did you mean speed?" in errors) == (2, True)

    status, out, _ = ask("call", "set_tread_damage", "damage=[{wheel: 2, a: 0.02, b: 0.016, h: 0.0005}]", "--json")
    assert status == 0
    assert json.loads(out)["revision"] == 2
    status, out, _ = ask("call", "set_speed", "speed=200")
    assert status == 1
    assert "out of range" in parse(out, "out")["message"]
    status, _, errors = ask("call", "set_speed", "sped=20")
    assert (status, "set_speed.sped is not a known field: did you mean speed?" in errors) == (2, True)
    status, _, errors = ask("call", "set_sped", "speed=20")
    assert (status, "did you mean /wheelset_track_sim/set_speed?" in errors) == (2, True)

    status, out, _ = ask("echo", "state", "--count", "1", "--json")  # latched
    assert status == 0
    assert json.loads(out)["scenario"].startswith("name: undamaged")
    status, out, _ = ask("echo", "contact_forces", "--count", "2")
    first, second, rest = out.split("---\n")
    assert (status, rest) == (0, "")
    assert " values from " in first
    assert parse(second, "out")["first_step"] > parse(first, "out")["first_step"]

    assert ask("call", "pause")[0] == 0


def test_an_interrupt_ends_a_topic_in_order(start, client, states, domain):
    start(scenario="undamaged", real_time_factor=0.2)
    client.until(lambda: states)
    own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-m", "wheelset_track_sim", "echo", "summary"]
    with subprocess.Popen(command, env=os.environ | own, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith(b"header:")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, b"")


def test_no_node_is_told_in_one_line(ask):
    status, out, errors = ask("get", "--node", "/nobody/here", "--timeout", "1")
    assert (status, out) == (1, "")
    assert errors.startswith("wheelset-track-sim: no node /nobody/here answers within 1 s in ROS_DOMAIN_ID ")
    assert len(errors.splitlines()) == 1
