"""The services of ``ros2 bag play``, where its interfaces are installed."""

import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def test_tools_that_know_ros2_bag_play(start, client, short_bag):
    pytest.importorskip("rosbag2_interfaces")
    from builtin_interfaces.msg import Time
    from rosbag2_interfaces import srv

    replay = start(short_bag, "--start-paused", "--loop", program="replay")
    client.name = "/rosbag2_player"

    def ask(name, kind, **fields):
        return client.call(name, getattr(srv, kind), again=False, **fields)

    assert ask("is_paused", "IsPaused").paused
    assert ask("play_next", "PlayNext").success
    assert ask("burst", "Burst", num_messages=3).actually_burst == 3
    ask("resume", "Resume")
    assert not ask("is_paused", "IsPaused").paused
    assert not ask("play_next", "PlayNext").success  # only while paused
    ask("toggle_paused", "TogglePaused")
    assert ask("is_paused", "IsPaused").paused
    ask("resume", "Resume")
    ask("pause", "Pause")
    assert ask("is_paused", "IsPaused").paused
    assert ask("set_rate", "SetRate", rate=2.5).success
    assert ask("get_rate", "GetRate").rate == 2.5
    assert not ask("set_rate", "SetRate", rate=-1.0).success
    assert ask("seek", "Seek", time=Time(sec=1_700_000_000, nanosec=20_000_000)).success
    assert not ask("seek", "Seek", time=Time(sec=5)).success
    ask("stop", "Stop")
    assert replay.wait() == 0, replay.errors
