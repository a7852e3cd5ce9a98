"""Print what a running node simulates, from its latched topic.

    .venv/bin/python examples/state.py

The node publishes `state` when something changes and keeps the last message for late subscribers. A subscriber receives
that message only with the same durability, transient local.
"""

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from wheelset_track_msgs.msg import SimulationState

TOPIC = "/wheelset_track_sim/state"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class State(Node):
    """A node that prints the state at once, and at each change."""

    def __init__(self) -> None:
        """Subscribe."""
        super().__init__("example_state")
        self.create_subscription(SimulationState, TOPIC, self.show, LATCHED)

    def show(self, state: SimulationState) -> None:
        """Print one line for a revision."""
        print(f"revision {state.revision}: {state.scenario_name}, {len(state.damage)} breakouts", flush=True)


def main() -> None:
    """Print until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(State())


if __name__ == "__main__":
    main()
