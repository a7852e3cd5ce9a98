"""Services and command topics of the node, as another process uses them."""

import math
import os
import threading
import time
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("wheelset_track_msgs")

from wheelset_track_sim.recording import read
from wheelset_track_sim.recording.damage import MOST
from wheelset_track_sim.scenario import load_scenario

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

RUNNING, PAUSED = 0, 1
SPEED = load_scenario("undamaged").speed
SIZE_B = {"a": 0.020, "b": 0.016, "h": 0.0015}


def assert_gap_free(chunks):
    for before, after in pairwise(chunks):
        assert after.first_step == before.first_step + len(before.wheel_1)


def first_of(chunks, revision):
    return next(chunk for chunk in chunks if chunk.revision >= revision)


class Services:
    """Calls of the node's services."""

    def __init__(self, client):
        self.client = client

    def trigger(self, name):
        from std_srvs.srv import Trigger

        return self.client.call(name, Trigger, again=False)

    def damage(self, *damage):
        from wheelset_track_msgs.srv import SetTreadDamage

        return self.client.call("set_tread_damage", SetTreadDamage, damage=[item(**fields) for fields in damage])

    def speed(self, speed, acceleration=0.0):
        from wheelset_track_msgs.srv import SetSpeed

        return self.client.call("set_speed", SetSpeed, speed=speed, acceleration=acceleration)

    def record(self, name=""):
        from wheelset_track_msgs.srv import StartRecording

        return self.client.call("start_recording", StartRecording, again=False, name=name)

    def pressure(self, wheel, at=0):
        from wheelset_track_msgs.srv import GetContactPressure

        return self.client.call("get_contact_pressure", GetContactPressure, wheel=wheel, at=at)


def item(**fields):
    from wheelset_track_msgs.msg import TreadDamage

    return TreadDamage(**{"wheel": 1, **SIZE_B, **fields})


@pytest.fixture
def services(client):
    return Services(client)


@pytest.fixture
def forces(client):
    return client.collect("contact_forces", "ContactForces")


@pytest.fixture
def states(client):
    return client.collect("state", "SimulationState", latched=True)


def test_damage_comes_into_force_at_the_step_of_the_answer(start, client, services, forces, states):
    start(scenario="undamaged")
    client.until(lambda: forces and states)
    answer = services.damage({}, {"wheel": 2, "angle": 1.0}, {"angle": 3.0, "y": 0.005}, {"h": 0.0})
    assert (answer.success, answer.message, answer.revision) == (True, "", 1)
    client.until(lambda: forces[-1].revision == 1)
    assert first_of(forces, 1).first_step == answer.step == states[-1].first_step
    assert_gap_free(forces)
    told = [(found.wheel, found.kind, found.a, found.h, found.angle, found.y) for found in states[-1].damage]
    assert told == [(1, 0, 0.02, 0.0015, 0.0, 0.0), (2, 0, 0.02, 0.0015, 1.0, 0.0), (1, 0, 0.02, 0.0015, 3.0, 0.005)]
    # the parameters show the first of each wheel; one that is set replaces it, the further stay
    assert client.get("wheel_1.damage.a", "wheel_1.damage.h", "wheel_2.damage.angle") == [0.02, 0.0015, 1.0]
    assert client.set(wheel_1__damage__h=0.001).successful
    client.until(lambda: states[-1].revision == 2)
    assert [(found.wheel, found.h) for found in states[-1].damage] == [(1, 0.001), (2, 0.0015), (1, 0.0015)]
    assert client.set(wheel_1__damage__h=0.0).successful  # takes the first away, and keeps its place
    client.until(lambda: states[-1].revision == 3)
    assert [(found.wheel, found.angle) for found in states[-1].damage] == [(2, 1.0), (1, 3.0)]
    assert client.set(wheel_1__damage__h=0.0005).successful
    client.until(lambda: states[-1].revision == 4)
    assert [(found.h, found.angle) for found in states[-1].damage] == [(0.0005, 0.0), (0.0015, 1.0), (0.0015, 3.0)]
    again = services.damage(
        *({name: getattr(found, name) for name in ("wheel", "h", "angle", "y")} for found in states[-1].damage)
    )
    assert (again.success, again.revision) == (True, 4)  # nothing new is no revision
    answer = services.damage()
    assert (answer.success, answer.revision) == (True, 5)
    assert client.get("wheel_1.damage.h", "wheel_2.damage.h") == [0.0, 0.0]
    client.until(lambda: states[-1].revision == 5)
    assert states[-1].damage == []
    assert_gap_free(forces)
