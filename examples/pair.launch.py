"""Start two wheelsets, one damaged, each in a process of its own; needs `ros2` and the built workspace.

    ros2 launch examples/pair.launch.py

The nodes are /train/leading and /train/trailing.
"""

from launch import LaunchDescription
from launch_ros.actions import Node

SCENARIOS = {"leading": "damage_wheel_1", "trailing": "undamaged"}


def generate_launch_description() -> LaunchDescription:
    """One node for each wheelset."""
    return LaunchDescription(
        [
            Node(
                package="wheelset_track_sim",
                executable="node",
                namespace="train",
                name=name,
                parameters=[{"scenario": scenario, "contact_forces.decimation": 10}],
                output="screen",
            )
            for name, scenario in SCENARIOS.items()
        ]
    )
