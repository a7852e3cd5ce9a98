"""Calls of the node's services, and what tests of them ask of the stream."""

import signal
from itertools import pairwise

SIZE_B = {"a": 0.020, "b": 0.016, "h": 0.0015}


def assert_gap_free(chunks):
    for before, after in pairwise(chunks):
        assert after.first_step == before.first_step + len(before.wheel_1)


def first_of(chunks, revision):
    return next(chunk for chunk in chunks if chunk.revision >= revision)


def end(node):
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


class Services:
    """Calls of the node's services."""

    def __init__(self, client):
        self.client = client

    def trigger(self, name):
        return self.client.trigger(name)

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
