"""The node's time: an outer clock that goes, stands and is set back, a clock of its own, stamps that never go back."""

import signal
import threading
import time
from itertools import pairwise

import numpy as np
import pytest

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

CHUNK = 0.05
MOMENT = 1e-6
TICK = 0.02
STANDS = 1.0
"""How long the test looks at something that must stand still, s."""


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def first_stamp(chunk):
    return seconds(chunk.header.stamp)


def last_stamp(chunk):
    """Stamp behind the last sample."""
    return first_stamp(chunk) + chunk.samples * chunk.step_period


def assert_one_time(chunks):
    """No gap, and stamps that count simulated time."""
    for before, after in pairwise(chunks):
        assert after.first_step == before.first_step + before.samples
        assert first_stamp(after) == pytest.approx(last_stamp(before), abs=MOMENT)


class OuterClock:
    """Tells the time on ``/clock``, as a simulator or a bag that is played does."""

    def __init__(self, client, now):
        from rosgraph_msgs.msg import Clock

        self.kind, self.now = Clock, now
        self.publisher = client.node.create_publisher(Clock, "/clock", 10)

    def tell(self):
        message = self.kind()
        message.clock.sec, nanosec = divmod(round(self.now * 1e9), 10**9)
        message.clock.nanosec = nanosec
        self.publisher.publish(message)

    def go(self, duration, rate):
        """Go on at a rate of the machine's clock, then stand."""
        for _ in range(round(duration / TICK)):
            self.now += TICK
            self.tell()
            time.sleep(TICK / rate)
        for _ in range(5):  # to a subscriber that takes what comes, or not
            self.tell()
            time.sleep(TICK)


def settled(read):
    """A reading that stays what it is: what was on its way when the time stood still has come."""
    while True:
        found = read()
        time.sleep(STANDS)
        if read() == found:
            return found


def stands(client, clock, chunks):
    """Wait until the stream has come to the clock; it stays there."""
    client.until(lambda: last_stamp(chunks[-1]) > clock.now - CHUNK - 0.001)
    count = len(chunks)
    time.sleep(STANDS)
    assert len(chunks) == count
    assert last_stamp(chunks[-1]) <= clock.now + MOMENT


def test_outer_clock_is_followed_however_it_goes(start, client, summaries, reports):
    node = start(scenario="undamaged", use_sim_time="true")
    clock = OuterClock(client, 1000.0)
    client.until(lambda: any(message == "waiting for the time on /clock" for _, message in reports))
    assert client.state() == "activating"
    assert not summaries
    clock.now = -1.0
    clock.tell()  # is no time, and not taken for one
    clock.now = 1000.0
    client.until(lambda: clock.tell() or reports[-1][1] == "running")
    clock.go(2.0, rate=4.0)
    stands(client, clock, summaries)
    assert first_stamp(summaries[0]) >= 1000.0
    clock.go(1.0, rate=0.5)
    stands(client, clock, summaries)
    assert client.transition("deactivate")  # also while time stands
    assert client.transition("activate")
    count = len(summaries)
    clock.now = 500.0  # a bag that is played again
    clock.go(1.0, rate=2.0)
    client.until(lambda: len(summaries) >= count + round(1.0 / CHUNK) - 2)
    clock.now += 2.0  # a leap: what is due comes at once, all of it
    clock.go(TICK, rate=1.0)
    client.until(lambda: len(summaries) >= count + round(3.0 / CHUNK) - 3)
    assert_one_time(summaries)
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "set back by" in node.errors + node.output


def test_waiting_for_a_clock_ends_with_a_signal(start, client, reports):
    node = start(scenario="undamaged", use_sim_time="true")
    client.until(lambda: any(message == "waiting for the time on /clock" for _, message in reports))
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


def test_waiting_for_a_clock_ends_with_the_wish_to_follow_one(start, client, summaries, reports):
    start(scenario="undamaged", use_sim_time="true")
    client.until(lambda: any(message == "waiting for the time on /clock" for _, message in reports))
    before = time.time()
    assert client.set(use_sim_time=False).successful
    client.until(lambda: len(summaries) >= 3)
    assert first_stamp(summaries[0]) >= before - MOMENT


def test_half_of_an_outer_clock(start, client, summaries):
    """Simulated time is ``real_time_factor`` of that on /clock; with 0 nobody looks at the clock."""
    start(scenario="undamaged", use_sim_time="true", real_time_factor=0.5)
    clock = OuterClock(client, 100.0)
    clock.tell()
    while not summaries:
        clock.go(0.1, rate=1.0)
    began, simulated = clock.now, settled(lambda: last_stamp(summaries[-1]))
    clock.go(4.0, rate=4.0)
    client.until(lambda: last_stamp(summaries[-1]) > simulated + 2.0 - CHUNK - 0.001)
    passed = settled(lambda: last_stamp(summaries[-1])) - simulated
    assert passed <= 0.5 * (clock.now - began) + CHUNK + MOMENT
    assert client.set(real_time_factor=0.0).successful
    count = len(summaries)
    client.until(lambda: len(summaries) > count + 100)
    assert_one_time(summaries)


class Follower:
    """A node with ``use_sim_time`` and what it hears on ``/clock``."""

    def __init__(self, make_client):
        from rclpy.parameter import Parameter
        from rosgraph_msgs.msg import Clock

        self.node = make_client("follower", parameter_overrides=[Parameter("use_sim_time", value=True)]).node
        self.heard = []
        self.node.create_subscription(Clock, "/clock", lambda message: self.heard.append(seconds(message.clock)), 500)

    @property
    def now(self):
        return self.node.get_clock().now().nanoseconds * 1e-9


@pytest.fixture
def follower(make_client):
    return Follower(make_client)


def test_others_follow_the_clock_of_the_node(start, client, summaries, follower):
    before = time.time()
    start(scenario="undamaged", publish_clock="true", real_time_factor=5.0)
    client.until(lambda: len(summaries) > 60 and len(follower.heard) > 60)
    assert client.transition("deactivate")
    stood = settled(lambda: last_stamp(summaries[-1]))
    client.until(lambda: follower.heard[-1] == pytest.approx(stood, abs=MOMENT, rel=0))
    client.until(lambda: follower.now == pytest.approx(stood, abs=MOMENT, rel=0))
    assert settled(lambda: follower.now) == pytest.approx(stood, abs=MOMENT, rel=0)
    assert stood > before + 60 * CHUNK
    assert client.transition("activate")
    client.until(lambda: follower.now > stood + 1.0)
    heard, ends = [*follower.heard], [last_stamp(chunk) for chunk in summaries]
    assert all(after > before for before, after in pairwise(heard))
    # A tick comes when a chunk is over; a queue of one tick may lose some, and either may have been heard earlier.
    told = [now for now in heard if ends[0] - MOMENT <= now <= ends[-1] + MOMENT]
    assert len(told) > 60
    assert np.abs(np.subtract.outer(told, ends)).min(axis=1).max() <= MOMENT


def test_two_that_tell_the_time_are_warned_of(start, client, summaries):
    OuterClock(client, 1.0)
    node = start(scenario="undamaged", publish_clock="true", autostart="false")
    assert client.transition("configure")
    client.until(lambda: client.node.count_publishers("/clock") == 2)
    assert client.transition("activate")
    client.until(lambda: summaries)
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "1 more publish on /clock" in node.errors + node.output


def test_node_cannot_follow_its_own_clock(start, client):
    both = start("--ros-args", "--log-level", "fatal", scenario="undamaged", publish_clock="true", use_sim_time="true")
    assert both.wait() == 2
    assert "publish_clock" in both.errors
    assert len(both.errors.strip().splitlines()) == 1
    start(scenario="undamaged", publish_clock="true", autostart="false")
    result = client.set(use_sim_time=True)
    assert not result.successful
    assert "publish_clock" in result.reason
    assert client.get("use_sim_time") == [False]


def test_clock_is_not_changed_under_a_run(start, client, summaries):
    start(scenario="undamaged")
    client.until(lambda: summaries)
    result = client.set(use_sim_time=True)
    assert not result.successful
    assert "clean up the node first" in result.reason
    assert client.get("use_sim_time") == [False]
    assert client.transition("deactivate")
    assert client.transition("cleanup")
    assert client.transition("configure")
    assert client.set(use_sim_time=True).successful  # of this run there is no stamp yet
    assert client.transition("cleanup")
    clock = OuterClock(client, 50.0)
    going = threading.Event()

    def keep_going():
        while not going.is_set():
            clock.go(0.1, rate=1.0)

    thread = threading.Thread(target=keep_going)
    thread.start()
    try:
        assert client.transition("configure")
        assert client.transition("activate")
        client.until(lambda: first_stamp(summaries[-1]) < 1e6)
    finally:
        going.set()
        thread.join()


def test_stamps_never_go_back(start, client, summaries):
    from std_srvs.srv import Trigger

    start(scenario="undamaged", real_time_factor=4.0)
    client.until(lambda: len(summaries) >= 5)

    def more(count=10):
        seen = len(summaries)
        client.until(lambda: len(summaries) >= seen + count)

    for factor in (0.0, 0.5, 20.0, 1.0):
        assert client.set(real_time_factor=factor).successful
        more(5)
    assert client.set(real_time_factor=4.0).successful
    assert client.call("pause", Trigger).success
    assert client.call("resume", Trigger).success
    more()
    assert client.transition("deactivate")
    assert client.transition("activate")
    more()
    assert_one_time(summaries)
    runs = len(summaries)
    assert client.call("reset", Trigger, again=False).success
    more()
    assert client.transition("deactivate")
    assert client.transition("cleanup")
    assert client.transition("configure")
    assert client.transition("activate")
    more()
    begun = [number for number in range(runs, len(summaries)) if summaries[number].first_step == 0]
    assert len(begun) == 2
    for first, last in pairwise([0, *begun, len(summaries)]):
        assert_one_time(summaries[first:last])
    for before, after in pairwise(summaries):
        assert first_stamp(after) >= last_stamp(before) - MOMENT
