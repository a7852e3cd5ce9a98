"""A bag of the real node, with changes from a client, simulated again without it."""

import random
import signal

import pytest

from wheelset_track_sim.bags import Bag
from wheelset_track_sim.twin import resimulate

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def test_a_run_that_a_client_has_changed_paused_and_split_is_bit_identical(start, client, tmp_path):
    from std_srvs.srv import Trigger
    from wheelset_track_msgs.msg import TreadDamage
    from wheelset_track_msgs.srv import SetSpeed, SetTreadDamage, StartRecording

    chance = random.Random(1)
    bags = {"record__directory": tmp_path, "record__name": "run", "record__on_start": "true"}
    node = start(scenario="damage_wheel_1", real_time_factor=2.0, chunk_duration=0.05, **bags)
    summaries = client.collect("summary", "LoadSummary")
    client.until(lambda: summaries)

    def damage():
        shapes = ((0.004, 0.008, 0.0005), (0.006, 0.012, 0.001))
        items = []
        for _ in range(chance.randrange(3)):
            a, b, h = chance.choice(shapes)
            wheel, angle = chance.choice((1, 2)), chance.uniform(0.0, 6.0)
            items.append(TreadDamage(wheel=wheel, kind=0, a=a, b=b, h=h, angle=angle, y=0.0))
        return client.call("set_tread_damage", SetTreadDamage, damage=items).success

    def speed():
        values = {"speed": chance.uniform(20.0, 35.0), "acceleration": chance.uniform(1.0, 10.0)}
        return client.call("set_speed", SetSpeed, **values).success

    def load():
        return client.set(axle_load=chance.uniform(150e3, 250e3)).successful

    for number in range(20):
        assert chance.choice((damage, speed, load))()
        if number == 8:
            assert client.call("split_recording", Trigger).success
        if number == 12:
            assert client.call("pause", Trigger).success
            assert load()
            assert client.call("resume", Trigger).success
        if number == 16:  # a bag that begins in the middle of the run
            assert client.call("stop_recording", Trigger).success
            assert client.call("start_recording", StartRecording, name="late").success
    newest = summaries[-1].revision
    client.until(lambda: summaries[-1].first_step > 2713 and summaries[-1].revision >= newest)
    assert node.signal(signal.SIGINT) == 0, node.errors

    for name in ("run", "late"):
        found = resimulate(tmp_path / name)
        assert found.identical, found
        assert found.inputs.start is None
        assert not found.unknown
        assert not found.origin
    assert len(Bag(tmp_path / "run").files) == 2
    assert resimulate(tmp_path / "run" / "run_1.mcap").identical
    first = next(Bag(tmp_path / "late").blocks())
    assert first.first_step > 0
