"""Print an alarm for each impact above a threshold.

    .venv/bin/python examples/alarm.py [THRESHOLD_IN_KN]

The node publishes an impact when the force exceeds its parameter `impact.threshold`, 200 kN by default. This monitor
uses a higher threshold of its own.
"""

import sys
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from wheelset_track_msgs.msg import WheelImpact

TOPIC = "/wheelset_track_sim/impacts"


class Alarm(Node):
    """A node that watches impacts."""

    def __init__(self, threshold: float) -> None:
        """Subscribe; ``threshold`` is a force in N."""
        super().__init__("example_alarm")
        self.threshold = threshold
        self.create_subscription(WheelImpact, TOPIC, self.judge, 10)

    def judge(self, impact: WheelImpact) -> None:
        """Print an alarm if the force is above the threshold."""
        if impact.peak_force > self.threshold:
            print(
                f"ALARM wheel {impact.wheel}: {impact.peak_force / 1e3:.1f} kN, {impact.dynamic_factor:.2f} times the "
                f"static load, at {impact.position:.3f} m, angle {impact.angle:.3f} rad of the tread",
                flush=True,
            )


def main() -> None:
    """Watch until Ctrl-C."""
    threshold = 1e3 * float(sys.argv[1]) if len(sys.argv) > 1 else 250e3
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Alarm(threshold))


if __name__ == "__main__":
    main()
