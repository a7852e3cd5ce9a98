"""Both wheelsets of a bogie, /bogie/leading and /bogie/trailing: ros2 launch wheelset_track_sim bogie.launch.py."""

from launch import LaunchDescription

from wheelset_track_sim.ros.launching import BOGIE, Value, Wheelset, description


def bogie(value: Value) -> list[Wheelset]:
    """Two nodes in a namespace."""
    return [(value("namespace"), name) for name in BOGIE]


def generate_launch_description() -> LaunchDescription:
    """Two nodes, each in a process of its own."""
    return description("train.yaml", bogie, namespace=("bogie", "name of the bogie: namespace of both nodes"))
