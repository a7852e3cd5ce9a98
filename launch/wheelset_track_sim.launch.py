"""One wheelset: ros2 launch wheelset_track_sim wheelset_track_sim.launch.py scenario:=undamaged record:=true."""

from launch import LaunchDescription

from wheelset_track_sim.ros.launching import NAMESPACE, PACKAGE, Value, Wheelset, description


def wheelset(value: Value) -> list[Wheelset]:
    """The node by its arguments."""
    return [(value("namespace"), value("name"))]


def generate_launch_description() -> LaunchDescription:
    """One node, of any name in any namespace."""
    return description("node.yaml", wheelset, name=(PACKAGE, "name of the node"), namespace=NAMESPACE)
