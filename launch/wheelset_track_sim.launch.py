"""The node with a parameter file: ros2 launch wheelset_track_sim wheelset_track_sim.launch.py scenario:=undamaged."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "wheelset_track_sim"


def generate_launch_description() -> LaunchDescription:
    """One node; arguments stand above the parameter file."""
    shipped = Path(get_package_share_directory(PACKAGE)) / "config" / "node.yaml"
    arguments = {
        "params_file": (str(shipped), "parameter file"),
        "scenario": ("damage_wheel_1", "name of a shipped scenario, or path of a scenario file"),
        "record": ("false", "whether to record from the start on"),
        "record_directory": ("recordings", "folder in which bags are written"),
    }
    node = Node(
        package=PACKAGE,
        executable="node",
        name=PACKAGE,
        output="screen",
        parameters=[
            LaunchConfiguration("params_file"),
            {
                "scenario": LaunchConfiguration("scenario"),
                "record.on_start": LaunchConfiguration("record"),
                "record.directory": LaunchConfiguration("record_directory"),
            },
        ],
    )
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in arguments.items()
    ]
    return LaunchDescription([*declared, node])
