"""The same message from the node and in a bag written without ROS."""

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("wheelset_track_msgs")

from rclpy.serialization import deserialize_message, serialize_message

from wheelset_track_sim.recording.definitions import serialise
from wheelset_track_sim.recording.messages import block_of, chunk_messages, state_message, state_of
from wheelset_track_sim.ros.conversions import to_ros

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_123_456_789


@pytest.fixture
def messages(make_block, make_state):
    block = make_block(1389, 1389, time=0.05)
    return [*chunk_messages(block, START_NS, real_time_factor=2.5, lag=0.1), state_message(make_state(block), START_NS)]


def test_every_message_of_a_bag_is_the_one_that_the_node_publishes(messages):
    assert {message.kind for message in messages} == {"ContactForces", "AxleStress", "LoadSummary", "SimulationState"}
    for message in messages:
        published, recorded = to_ros(message), bytes(serialise(message.kind, message.fields))
        assert deserialize_message(recorded, type(published)) == published, message.kind
        assert len(serialize_message(published)) == len(recorded)  # the bytes of paddings are anything


def test_block_and_state_come_back_bit_by_bit(make_block, make_state, messages):
    block = make_block(1389, 1389, time=0.05)
    received = {
        message.topic: deserialize_message(serialize_message(to_ros(message)), type(to_ros(message)))
        for message in messages
    }
    stresses = [received[f"axle_stress/{node.lower()}"] for node in block.nodes]
    back = block_of(received["contact_forces"], stresses)
    np.testing.assert_array_equal(back.forces, block.forces)
    np.testing.assert_array_equal(back.stresses, block.stresses)
    assert state_of(received["state"]) == make_state(block)
