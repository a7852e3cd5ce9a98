"""All wheelsets of a train: ros2 launch wheelset_track_sim train.launch.py vehicles:=2.

They are called /train/vehicle_1/bogie_1/leading and so on. Each is a process of its own, which needs about a core at
real time: ``real_time_factor:=0.25`` lets four share one.
"""

from itertools import product

from launch import LaunchDescription

from wheelset_track_sim.ros.launching import BOGIE, Value, Wheelset, description
from wheelset_track_sim.ros.names import counted


def train(value: Value) -> list[Wheelset]:
    """Two nodes for each bogie of each vehicle, which are namespaces."""
    vehicles, bogies = (range(1, counted(value(name), f"{name}:=") + 1) for name in ("vehicles", "bogies"))
    return [
        (f"{value('namespace')}/vehicle_{vehicle}/bogie_{bogie}".lstrip("/"), name)
        for vehicle, bogie, name in product(vehicles, bogies, BOGIE)
    ]


def generate_launch_description() -> LaunchDescription:
    """A node for each wheelset."""
    return description(
        "train.yaml",
        train,
        vehicles=("1", "number of vehicles"),
        bogies=("2", "number of bogies of each vehicle"),
        namespace=("train", "name of the train: namespace of all nodes"),
    )
