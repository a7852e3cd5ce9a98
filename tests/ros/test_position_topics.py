"""Frames of a node by its name, and its position as standard messages."""

import pytest

from support.service_calls import end
from wheelset_track_sim.errors import InputError

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(
    ("node", "prefix", "frames"),
    [
        ("/wheelset_track_sim", "", ("track", "wheelset")),
        ("/train/vehicle_1/leading", "", ("train/vehicle_1/leading/track", "train/vehicle_1/leading/wheelset")),
        ("/wheelset_track_sim", "IC-2.75/axle_1", ("IC-2.75/axle_1/track", "IC-2.75/axle_1/wheelset")),
    ],
)
def test_frames_have_the_name_of_the_node_or_a_prefix(node, prefix, frames):
    from wheelset_track_sim.ros.position import Frames

    assert Frames.of(node, prefix) == Frames(*frames)


@pytest.mark.parametrize("prefix", ["/leading", "leading/", "a//b", "first axle", "ä", "a" * 201])
def test_a_prefix_that_tf_cannot_have_is_refused(prefix):
    from wheelset_track_sim.ros.position import Frames

    with pytest.raises(InputError, match="is no name of a frame"):
        Frames.of("/wheelset_track_sim", prefix)


@pytest.mark.slow
def test_position_and_frames_of_a_named_node(start, client):
    nav_msgs = pytest.importorskip("nav_msgs.msg")

    client.name = "/train/leading"
    forces, states = client.collect("contact_forces", "ContactForces"), client.collect("state", "SimulationState", True)
    found = []

    def take(message):
        with client.arrived:
            found.append(message)
            client.arrived.notify_all()

    client.node.create_subscription(nav_msgs.Odometry, f"{client.name}/odometry", take, 100)
    node = start(
        *("--ros-args", "-r", "__ns:=/train", "-r", "__node:=leading"),
        scenario="undamaged",
        publish_odometry="true",
        contact_forces__decimation=4,
    )
    client.until(lambda: len(found) > 5 and len(forces) > 5 and states)
    for message in (*forces, *states):
        assert message.header.frame_id == "train/leading/track"
    last = found[-1]
    assert (last.header.frame_id, last.child_frame_id) == ("train/leading/track", "train/leading/wheelset")
    begin, now = states[-1].header.stamp, last.header.stamp
    since = states[-1].time + now.sec - begin.sec + 1e-9 * (now.nanosec - begin.nanosec)
    assert last.pose.pose.position.x == pytest.approx(27.7777778 * since, abs=2e-3)
    assert last.twist.twist.linear.x == 27.7777778
    assert last.pose.pose.orientation.w == 1.0
    end(node)


@pytest.mark.slow
def test_transforms_without_their_package_are_refused(start):
    from importlib.util import find_spec

    if find_spec("tf2_msgs") is not None:
        pytest.skip("tf2_msgs is installed")
    node = start(publish_tf="true")
    assert node.wait() == 2
    assert "publish_tf = true needs tf2_msgs, which is not installed" in node.errors
