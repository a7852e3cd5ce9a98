"""Examples that talk to a running node: each as a process of its own, as a user starts it."""

import os
import signal
import subprocess
import sys

import pytest

from support.paths import ROOT

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.fixture
def example(domain):
    """Start an example in the domain of the test."""
    begun = []
    environment = os.environ | {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}

    def example(name, *arguments):
        command = [sys.executable, str(ROOT / "examples" / name), *arguments]
        process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        begun.append(process)
        return process

    yield example
    for process in begun:
        process.kill()
        process.communicate()


def test_subscriber_alarm_and_parameter_client(start, example):
    subscriber, alarm, state = example("subscriber.py"), example("alarm.py", "220"), example("state.py")
    start(scenario="damage_wheel_1")
    assert "kN  A1 " in subscriber.stdout.readline()
    assert alarm.stdout.readline().startswith("ALARM wheel 1: ")
    assert state.stdout.readline() == "revision 0: damage_wheel_1, 1 breakouts\n"
    late = example("state.py")
    assert late.stdout.readline() == "revision 0: damage_wheel_1, 1 breakouts\n"
    client = example("set_damage.py", "0.5")
    assert "revision 1" in client.communicate(timeout=120)[0]
    assert client.returncode == 0
    for process in (subscriber, alarm, state, late):
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        assert process.returncode == 0
