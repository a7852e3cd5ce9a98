"""Several wheelsets, each node in a process of its own: ros2 launch wheelset_track_sim fleet.launch.py wheelsets:=4.

``wheelset-track-sim node --fleet 4`` has the same nodes in one process, which needs less memory; processes of their own
use all cores and end each for itself.
"""

from launch import LaunchDescription

from wheelset_track_sim.ros.launching import NAMESPACE, Value, Wheelset, description
from wheelset_track_sim.ros.names import fleet_names


def fleet(value: Value) -> list[Wheelset]:
    """A node for each wheelset, by number or by name."""
    return [(value("namespace"), name) for name in fleet_names(value("wheelsets"), "wheelsets:=")]


def generate_launch_description() -> LaunchDescription:
    """As many nodes as ``wheelsets`` says, with a parameter file in common that has a section for each name."""
    return description(
        "fleet.yaml", fleet, wheelsets=("3", "how many, or their names: leading,trailing"), namespace=NAMESPACE
    )
