"""What the launch files have in common: their arguments, and the node of a wheelset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from importlib.resources import files
from typing import Any, NamedTuple

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = "wheelset_track_sim"
Shown = Mapping[str, tuple[str, type, str]]
"""Launch arguments that stand for a parameter: its name, its type, what it does."""


class Program(NamedTuple):
    """What is started."""

    executable: str
    arguments: Shown


PARAMETERS: Shown = {
    "scenario": ("scenario", str, "name of a shipped scenario, or path of a scenario file"),
    "autostart": ("autostart", bool, "configure and activate without being told: true or false"),
    "real_time_factor": ("real_time_factor", float, "simulated time over elapsed time; 0 is as fast as possible"),
    "use_sim_time": ("use_sim_time", bool, "follow the time on /clock: true or false"),
    "record": ("record.on_start", bool, "record from the start of the run on: true or false"),
    "record_directory": ("record.directory", str, "folder in which bags are written, named by date, time and node"),
}
OF_REPLAY: Shown = {
    "bag": ("bag", str, "bag folder or .mcap file"),
    "rate": ("rate", float, "times as fast as recorded; 0 is as fast as possible"),
    "loop": ("loop", bool, "begin again at the end: true or false"),
    "start_offset": ("start_offset", float, "time behind the first message at which the replay begins, s"),
    "duration": ("duration", float, "time of the bag after which the replay ends, s; 0 is all of it"),
    "start_paused": ("start_paused", bool, "wait to be told to go on: true or false"),
    "stamps": ("stamps", str, "original, or now: those of a run that begins now"),
    "publish_clock": ("publish_clock", bool, "tell the time of the replay on /clock: true or false"),
    "prefix": ("prefix", str, "name of the node that topics get; ~ is this node's"),
    "use_sim_time": ("use_sim_time", bool, "follow the time on /clock: true or false"),
}
NODE, REPLAY = Program("node", PARAMETERS), Program("replay", OF_REPLAY)
BOGIE = ("leading", "trailing")
"""Wheelsets of a bogie."""
NAMESPACE = ("", "namespace of all nodes; empty: none")
Value = Callable[[str], str]
"""Value of a launch argument by its name."""
Wheelset = tuple[str, str]
"""Namespace and name of a node."""


def description(
    parameters: str,
    wheelsets: Callable[[Value], Iterable[Wheelset]],
    program: Program = NODE,
    /,
    **own: tuple[str, str],
) -> LaunchDescription:
    """A process of ``program`` for each of ``wheelsets``, which takes them from the values of the arguments.

    ``parameters`` is the shipped parameter file to start from; ``own`` are the arguments of this launch file, each with
    default and description. An argument that stands for a parameter is empty by default: the file holds then.
    """
    shipped = files(PACKAGE) / "data" / "config" / parameters
    arguments = {
        **own,
        "params_file": (str(shipped), "parameter file; what the other arguments give stands above it"),
        **{name: ("", f"{told}; empty: as in the parameter file") for name, (_, _, told) in program.arguments.items()},
        "log_level": ("info", "least level of what is logged: debug, info, warn, error, fatal"),
    }

    def nodes(context: LaunchContext) -> list[Node]:
        def value(argument: str) -> str:
            return str(LaunchConfiguration(argument).perform(context))

        return [_node(program, namespace, name, value) for namespace, name in wheelsets(value)]

    declared = [
        DeclareLaunchArgument(name, default_value=default, description=told)
        for name, (default, told) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])


def _node(program: Program, namespace: str, name: str, value: Value) -> Node:
    given: dict[str, Any] = {
        parameter: ParameterValue(LaunchConfiguration(argument), value_type=kind)
        for argument, (parameter, kind, _) in program.arguments.items()
        if value(argument)
    }
    return Node(
        package=PACKAGE,
        executable=program.executable,
        namespace=namespace,
        name=name,
        output="screen",
        parameters=[value("params_file"), *([given] if given else [])],
        ros_arguments=["--log-level", value("log_level")],
    )
