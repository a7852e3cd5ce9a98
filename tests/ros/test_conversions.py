"""The same message from the node and in a bag written without ROS."""

import numpy as np
import pytest

from wheelset_track_sim.bags.messages import block_of, chunk_messages, state_message, state_of

pytestmark = pytest.mark.ros

START_NS = 1_700_000_000_123_456_789


@pytest.fixture
def messages(make_block, make_state):
    block = make_block(1389, 1389, time=0.05)
    return [*chunk_messages(block, START_NS, real_time_factor=2.5, lag=0.1), state_message(make_state(block), START_NS)]


def received_by_ros(message):
    from rclpy.serialization import deserialize_message

    from wheelset_track_sim.ros.conversions import message_type

    return deserialize_message(message.cdr, message_type(message.kind))


def test_ros_reads_every_message_and_writes_it_as_the_node_does(messages):
    from rclpy.serialization import serialize_message

    assert {message.kind for message in messages} == {"ContactForces", "AxleStress", "LoadSummary", "SimulationState"}
    for message in messages:
        received = received_by_ros(message)
        plain = message.fields | {"header": received.header}
        for name in received.get_fields_and_field_types():
            assert_same(getattr(received, name), plain[name])
        stamp = message.fields["header"]["stamp"]
        assert (received.header.stamp.sec, received.header.stamp.nanosec) == (stamp["sec"], stamp["nanosec"])
        assert len(serialize_message(received)) == len(message.cdr)  # the bytes of paddings are anything


def assert_same(received, given):
    if isinstance(given, np.ndarray):
        assert np.asarray(received).tobytes() == given.tobytes()
    elif isinstance(given, tuple):
        for one, other in zip(received, given, strict=True):
            assert {name: getattr(one, name) for name in other} == other
    else:
        assert received == given or (np.isnan(received) and np.isnan(given))


def test_block_and_state_come_back_bit_by_bit(make_block, make_state, messages):
    block = make_block(1389, 1389, time=0.05)
    received = {message.topic: received_by_ros(message) for message in messages}
    stresses = [received[f"axle_stress/{node.lower()}"] for node in block.nodes]
    back = block_of(received["contact_forces"], stresses)
    np.testing.assert_array_equal(back.forces, block.forces)
    np.testing.assert_array_equal(back.stresses, block.stresses)
    assert state_of(received["state"]) == make_state(block)
