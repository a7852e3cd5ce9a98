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

    def answer(parameters, patience):
        """Answer to a request, or None if none comes within ``patience`` s."""
        future = client.set_parameters_atomically(parameters)
        rclpy.spin_until_future_complete(node, future, timeout_sec=patience)
        return future.result().result if future.done() else None

    # ROS loses the answer to a client that the node has not discovered yet: set nothing until an answer comes.
    known = client.wait_for_services(timeout_sec=20.0) and any(answer([], patience=1.0) for _ in range(20))
    values = {"wheel_1.damage.a": 0.030, "wheel_1.damage.b": 0.024, "wheel_1.damage.h": depth}
    result = answer([Parameter(name, value=value) for name, value in values.items()], patience=120.0) if known else None
    rclpy.shutdown()
    if result is None:
        print("/wheelset_track_sim does not answer: start the node first")
        return 1
    print(result.reason or "nothing changes: the node has these values")
    return 0 if result.successful else 1


if __name__ == "__main__":
    sys.exit(main())
