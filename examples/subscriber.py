"""Print the peaks of each chunk that a running node publishes.

    .venv/bin/python examples/subscriber.py

The topic `summary` has scalars of each chunk, computed from every step: use it to watch and to plot.
"""

from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from wheelset_track_msgs.msg import LoadSummary

TOPIC = "/wheelset_track_sim/summary"


class Subscriber(Node):
    """A node that prints summaries."""

    def __init__(self) -> None:
        """Subscribe."""
        super().__init__("example_subscriber")
        self.create_subscription(LoadSummary, TOPIC, self.show, 10)

    def show(self, summary: LoadSummary) -> None:
        """Print one line for a chunk."""
        forces = f"{summary.wheel_1_max_force / 1e3:6.1f} {summary.wheel_2_max_force / 1e3:6.1f} kN"
        stresses = [
            f"{name} {stress / 1e6:.1f}" for name, stress in zip(summary.nodes, summary.max_principal_max, strict=True)
        ]
        print(f"{summary.time:8.2f} s  {forces}  {' '.join(stresses)} MPa", flush=True)


def main() -> None:
    """Print until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Subscriber())


if __name__ == "__main__":
    main()
