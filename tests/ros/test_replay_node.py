"""Bags played by real processes over the real middleware, to subscribers that were written for the node."""

import re
import signal
import statistics
import time
from itertools import pairwise

import pytest

from support.paths import OLD_BAG
from support.replaying import NODE, Subscriber, by_topic, padded, recorded
from wheelset_track_sim.bags.playback.recorded_bag import RecordedBag
from wheelset_track_sim.cli.run import run

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

LATE = 0.010
"""Bound on the time by which a message may miss its own, s."""
ATTEMPTS = 8
"""Others have the machine, too: that many times it may be they who are in the way."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Two seconds with impacts, recorded without ROS."""
    path = tmp_path_factory.mktemp("bags") / "run.mcap"
    assert run("damage_wheel_1", ["speed=40"], 2.0, path, json=True) == 0
    return path


@pytest.fixture
def play(start):
    """Play a bag: options and parameters of the replay."""

    def play(*arguments, **parameters):
        return start(*arguments, program="replay", **parameters)

    return play


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def clocks_of(client):
    from rclpy.qos import QoSProfile
    from rosgraph_msgs.msg import Clock

    found = []
    client.node.create_subscription(
        Clock, "/clock", lambda tick: found.append(tick.clock.sec * 10**9 + tick.clock.nanosec), QoSProfile(depth=1000)
    )
    return found


def test_subscribers_cannot_tell_it_from_the_node(start, play, client, make_client, tmp_path):
    """What was heard of a running node is heard again, bit by bit, and all else that its bag holds."""
    forces = client.collect("contact_forces", "ContactForces")
    where = {"record__directory": tmp_path, "record__name": "live", "record__on_start": "true"}
    node = start(scenario="damage_wheel_1", chunk_duration=0.03, **where)
    client.until(lambda: len(forces) >= 30)
    assert client.set(speed=28.0).successful  # a revision on the way
    client.until(lambda: forces[-1].revision == 1)
    seen = len(forces)
    client.until(lambda: len(forces) >= seen + 10)
    assert node.signal(signal.SIGINT) == 0
    stored, live = by_topic(recorded(tmp_path / "live")), [*forces]

    listener = Subscriber(make_client("listener"), tmp_path / "live")
    replay = play(tmp_path / "live", "--start-paused")
    listener.connect()
    client.meet()  # the replay has discovered the subscription of the forces, too
    assert listener.play_to_the_end(stored) == stored
    assert replay.wait() == 0, replay.errors
    client.until(lambda: len(forces) > len(live) and forces[-1].first_step >= live[-1].first_step)
    again = forces[len(live) :]  # by the same subscription
    steps = [message.first_step for message in again]
    begun = len(steps) - 1 - steps[::-1].index(0)
    first = steps.index(live[0].first_step, begun)
    assert again[first : first + len(live)] == live
    assert "damaged" not in replay.errors + replay.output


def test_a_bag_of_version_0_1_is_played(play, client):
    """States and summaries have fields more since: subscribers get messages of today's types."""
    stored = by_topic(recorded(OLD_BAG))
    with RecordedBag(OLD_BAG) as bag:
        conversions = {name: topic.conversion for name, topic in bag.topics.items() if topic.conversion}
    assert {*conversions} == {f"{NODE}/state", f"{NODE}/summary"}
    for topic, conversion in conversions.items():
        stored[topic] = [padded(conversion(cdr)) for cdr in stored[topic]]
    listener = Subscriber(client, OLD_BAG)
    node = play(OLD_BAG, "--loop", "--start-paused")
    listener.connect()
    for _ in range(3):
        assert client.trigger("play_next").success
    client.until(
        lambda: all(by_topic([*listener.arrived])[topic][-len(items) :] == items for topic, items in stored.items())
    )
    assert node.signal(signal.SIGINT) == 0
    assert "WARN" not in node.errors


def test_every_chunk_leaves_at_its_time(play, client, bag):
    """By the replay's own record of each message, and by the arrivals at a subscriber; the best of some attempts."""
    stored = [item for item in recorded(bag) if item.topic == f"{NODE}/contact_forces"]
    wanted = [(item.time_ns - stored[0].time_ns) * 1e-9 for item in stored]
    listener = Subscriber(client, bag)
    worst, median = [], []
    for _ in range(ATTEMPTS):
        listener.arrived.clear()
        replay = play(bag)
        assert replay.wait() == 0, replay.errors
        [told] = re.findall(r"played (\d+) messages, at most (\S+) ms late", replay.output + replay.errors)
        assert int(told[0]) == len(recorded(bag))
        worst.append(float(told[1]) * 1e-3)
        arrived = [item for item in listener.arrived if item.topic == f"{NODE}/contact_forces"]
        places = {item.cdr: place for place, item in enumerate(stored)}
        offsets = [item.at - wanted[places[item.cdr]] for item in arrived]
        if len(offsets) > len(stored) / 2:  # those before the discovery are not heard
            median.append(statistics.median(abs(offset - statistics.median(offsets)) for offset in offsets))
        if worst[-1] < LATE and median:
            break
    assert min(worst) < LATE
    assert min(median) < LATE


def test_controls(play, client, bag):
    forces = client.collect("contact_forces", "ContactForces")
    replay = play(bag, "--start-paused", "--rate", 0)
    first = client.trigger("play_next")
    assert (first.success, first.message) == (True, "paused at 0.035 s")
    while not client.hears(lambda: forces):  # until the replay knows who listens
        assert client.trigger("play_next").success
    samples = len(forces[0].wheel_1)

    def steps_to(first_step):
        """One more chunk, and no other."""
        before = len(forces)
        assert client.trigger("play_next").success
        client.until(lambda: forces[-1].first_step == first_step)
        assert len(forces) <= before + 2  # the one before may have been on its way

    played = round((float(client.trigger("pause").message.split()[2]) + 1e-3) / (samples * forces[0].step_period))
    for number in range(3):
        steps_to((played + number) * samples)

    refused = client.set(position=99.0)
    assert not refused.successful
    assert re.match(r"position = 99 s is out of range: give a time from 0 s to before 2 s", refused.reason)
    assert client.set(position=1.0).successful
    steps_to(-(-round(1.0 / forces[0].step_period) // samples) * samples)
    assert client.trigger("reset").success
    steps_to(0)

    assert not client.set(rate=-1.0).successful
    assert client.set(rate=0.5).successful
    assert client.get("rate") == [0.5]
    assert client.trigger("toggle_paused").message.startswith("running at 0.")
    assert client.trigger("play_next").message == "the replay is running: pause it first"
    client.until(lambda: forces[-1].first_step == 3 * samples)
    assert client.trigger("pause").message.startswith("paused at 0.")
    assert client.trigger("pause").success  # as the node: it is so already
    assert client.trigger("resume").success
    assert client.set(rate=0.75).successful  # not so fast that the end overtakes the answer
    assert replay.wait() == 0, replay.errors


def test_stop_ends_it(play, client, bag):
    replay = play(bag, "--loop")
    assert client.trigger("stop").success
    assert replay.wait() == 0, replay.errors


def test_current_stamps_go_on_through_loops_and_the_clock_with_them(play, client, bag):
    began = time.time_ns()
    forces = client.collect("contact_forces", "ContactForces")
    stress = client.collect("axle_stress/b1", "AxleStress")
    ticks = clocks_of(client)
    replay = play(bag, "--loop", "--stamps", "now", "--publish-clock", "--duration", 0.4, "--rate", 4)
    client.until(lambda: sum(chunk.first_step == 0 for chunk in forces) >= 3 and len(stress) > len(forces) - 3)
    now = time.time_ns()
    assert replay.signal(signal.SIGINT) == 0, replay.errors
    stamps = [stamp_ns(message) for message in forces]
    assert began < stamps[0] < began + 4 * (now - began)
    spans = {round(chunk.step_period * len(chunk.wheel_1) * 1e9) for chunk in forces}
    steps = [after - before for before, after in pairwise(stamps)]
    # Chunks meet, also where the bag begins again: there the part that is played, 0.4 s, is not a whole number of them.
    assert all(0 < step <= max(spans) + 2 for step in steps)
    assert sum(abs(step - max(spans)) > 2 for step in steps) <= sum(chunk.first_step == 0 for chunk in forces)
    assert {stamp_ns(message) for message in stress[1:-1]} <= {*stamps, *(stamp + max(spans) for stamp in stamps)}
    assert ticks == sorted(ticks)
    told = [tick for tick in ticks if stamps[1] < tick < stamps[-1]]  # a queue of one tick may lose some
    assert {*told} <= {stamp + span for stamp in stamps for span in spans}
    assert len(told) > 3
    assert forces[0].time < 0.4  # all else is as recorded


def test_recorded_stamps_come_again_with_each_loop_and_the_clock_is_set_back(play, client, bag):
    forces = client.collect("contact_forces", "ContactForces")
    states = client.collect("state", "SimulationState", latched=True)
    ticks = clocks_of(client)
    replay = play(
        bag,
        "--loop",
        "--rate",
        4,
        "--ros-args",
        "-p",
        "start_offset:=1.0",
        "-p",
        "duration:=0.4",
        "-p",
        "publish_clock:=true",
    )
    client.until(lambda: len({message.first_step for message in forces}) < len(forces) - 2)
    client.until(lambda: states)
    assert replay.signal(signal.SIGINT) == 0, replay.errors
    assert {stamp_ns(message) - round(message.time * 1e9) for message in forces} <= {-1, 0, 1}  # recorded from 0 on
    assert all(1.0 <= message.time < 1.4 for message in forces)
    assert any(after < before for before, after in pairwise(ticks))
    assert states[0].first_step == 0  # what holds there was told before
    assert {1.0 <= tick * 1e-9 <= 1.5 for tick in ticks} == {True}


def test_under_another_name(play, client, bag):
    """In the namespace and under the name of the replay node itself, some of it elsewhere."""
    names = {f"{NODE}/summary": "/elsewhere"}
    listener = Subscriber(client, bag, lambda name: names.get(name, name.replace(NODE, "/train/w1")))
    client.name = "/train/w1"
    remapping = ["-r", "__ns:=/train", "-r", "__node:=w1", "-r", "/train/w1/summary:=/elsewhere"]
    play(bag, "--start-paused", "--prefix", "~", "--rate", 0, "--ros-args", *remapping)
    listener.connect()

    def own():
        return {name for name, _ in client.node.get_publisher_names_and_types_by_node("w1", "/train")}

    client.until(lambda: {"/elsewhere", "/train/w1/contact_forces"} < own())  # endpoints are heard of one by one
    assert not [name for name in own() if name.startswith(NODE)]
    stored = by_topic(recorded(bag))
    assert listener.play_to_the_end(stored) == stored


def test_waits_for_the_clock_and_follows_it(play, client, bag):
    from rosgraph_msgs.msg import Clock

    forces = client.collect("contact_forces", "ContactForces")
    clock = client.node.create_publisher(Clock, "/clock", 1)
    replay = play(bag, use_sim_time="true")
    tick = Clock()
    tick.clock.sec = 100
    while not client.node.count_subscribers("/clock"):
        client.check_nodes()
        time.sleep(0.05)
    while len(forces) < 10:
        client.check_nodes()
        tick.clock.nanosec += 50_000_000
        tick.clock.sec, tick.clock.nanosec = tick.clock.sec + tick.clock.nanosec // 10**9, tick.clock.nanosec % 10**9
        clock.publish(tick)
        time.sleep(0.02)
    assert "the replay" not in client.set(use_sim_time=False).reason
    assert replay.process.poll() is None
    assert replay.signal(signal.SIGTERM) == 0, replay.errors


def test_a_damaged_bag_plays_as_far_as_it_can_be_read(play, client, bag, tmp_path):
    broken = tmp_path / "broken.mcap"
    content = bytearray(bag.read_bytes())
    content[len(content) // 3] ^= 0xFF
    broken.write_bytes(content[: 2 * len(content) // 3])
    replay = play(broken, "--rate", 0)
    assert replay.wait() == 0, replay.errors
    told = re.findall(r"damaged: (\S+): bytes (\d+) to (\d+): (.*)", replay.output + replay.errors)
    assert len(told) == 2
    assert {name for name, *_ in told} == {"broken.mcap"}
    [count] = re.findall(r"played (\d+) messages", replay.output + replay.errors)
    assert 0.3 * len(recorded(bag)) < int(count) < 0.7 * len(recorded(bag))


BAD = {
    "no bag": ([], "bag is missing: give a bag folder or an .mcap file", 2),
    "missing": (["nowhere.mcap"], "nowhere.mcap does not exist", 2),
    "rate": (["BAG", "--rate", "-1"], "rate", 2),
    "stamps": (["BAG", "--stamps", "later"], "stamps = later is not known: give one of original, now", 2),
    "offset": (["BAG", "--start-offset", "5"], "start_offset = 5 s is after the end of the bag", 2),
    "prefix": (["BAG", "--prefix", "not a name"], "prefix = not a name", 2),
    "two clocks": (
        ["BAG", "--publish-clock", "--ros-args", "-p", "use_sim_time:=true"],
        "use_sim_time and publish_clock cannot both be true",
        2,
    ),
    "option": (["BAG", "--speed", "2"], "unrecognized arguments: --speed 2", 2),
    "ros": (["BAG", "--ros-args", "--what"], "arguments of ROS", 2),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_used_is_refused_in_one_line(bag, name, domain, monkeypatch, capfd):
    from wheelset_track_sim.cli import main

    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    arguments, told, status = BAD[name]
    assert main(["replay", *(str(bag) if item == "BAG" else item for item in arguments)]) == status
    errors = capfd.readouterr().err
    [line] = [line for line in errors.splitlines() if line.startswith("wheelset-track-sim: ")]
    assert told in line
    assert "Traceback" not in errors


def test_parameters_describe_themselves_and_every_option_is_one(play, client, bag):
    from rcl_interfaces.srv import DescribeParameters

    play(
        bag, "--start-paused", "--loop", "--prefix", "/x/", "--stamps", "now", "--duration", 1.5, "--start-offset", 0.25
    )
    names = ["bag", "loop", "prefix", "stamps", "duration", "start_offset", "start_paused", "rate", "position"]
    assert client.get(*names) == [str(bag), True, "/x/", "now", 1.5, 0.25, True, 1.0, 0.25]
    described = client.call("describe_parameters", DescribeParameters, names=names).descriptors
    assert all(item.description for item in described)
    assert {item.name for item in described if not item.read_only} == {"loop", "rate", "position"}
    assert not client.set(bag="another").successful
