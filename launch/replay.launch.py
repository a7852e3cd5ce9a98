"""A bag played again: ros2 launch wheelset_track_sim replay.launch.py bag:=recordings/run rate:=2.0."""

from launch import LaunchDescription

from wheelset_track_sim.ros.launching import NAMESPACE, PACKAGE, REPLAY, Value, Wheelset, description


def player(value: Value) -> list[Wheelset]:
    """The node by its arguments."""
    return [(value("namespace"), value("name"))]


def generate_launch_description() -> LaunchDescription:
    """One replay node, of any name in any namespace."""
    return description("replay.yaml", player, REPLAY, name=(PACKAGE, "name of the node"), namespace=NAMESPACE)
