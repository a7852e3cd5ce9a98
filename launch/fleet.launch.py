"""Several wheelsets, each node in a process of its own: ros2 launch wheelset_track_sim fleet.launch.py wheelsets:=4.

``wheelset-track-sim node --fleet 4`` has the same nodes in one process, which needs less memory; processes of their own
use all cores and end each for itself.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

PACKAGE = "wheelset_track_sim"


def nodes(context: LaunchContext) -> list[Node]:
    """A node for each wheelset, by number or by name."""
    wheelsets = LaunchConfiguration("wheelsets").perform(context)
    names = [f"wheelset_{i + 1}" for i in range(int(wheelsets))] if wheelsets.isdigit() else wheelsets.split(",")
    return [
        Node(
            package=PACKAGE,
            executable="node",
            name=name,
            namespace=LaunchConfiguration("namespace"),
            output="screen",
            parameters=[LaunchConfiguration("params_file")],
        )
        for name in names
    ]


def generate_launch_description() -> LaunchDescription:
    """As many nodes as ``wheelsets`` says, with a parameter file in common that has a section for each name."""
    shipped = Path(get_package_share_directory(PACKAGE)) / "config" / "fleet.yaml"
    arguments = {
        "wheelsets": ("3", "how many, or their names: leading,trailing"),
        "namespace": ("", "namespace of all of them"),
        "params_file": (str(shipped), "parameter file"),
    }
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
