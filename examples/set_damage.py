"""Change the damage of wheel 1 in a running node, in one revision.

    .venv/bin/python examples/set_damage.py [DEPTH_IN_MM]

The node answers when it has accepted or rejected the values. New damage takes effect once the old one has rolled out of
the contact patch.
"""

import sys

import rclpy
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient


def main() -> int:
    """Set the values, and print the answer; returns 0, or 1 if the node rejects them."""
    depth = 1e-3 * float(sys.argv[1]) if len(sys.argv) > 1 else 1e-3
    rclpy.init()
    node = rclpy.create_node("example_set_damage")
    client = AsyncParameterClient(node, "/wheelset_track_sim")
    if not client.wait_for_services(timeout_sec=20.0):
        print("/wheelset_track_sim does not answer: start the node first")
        return 1
    values = {"wheel_1.damage.a": 0.030, "wheel_1.damage.b": 0.024, "wheel_1.damage.h": depth}
    future = client.set_parameters_atomically([Parameter(name, value=value) for name, value in values.items()])
    rclpy.spin_until_future_complete(node, future)
    result = future.result().result
    rclpy.shutdown()
    print(result.reason)
    return 0 if result.successful else 1


if __name__ == "__main__":
    sys.exit(main())
