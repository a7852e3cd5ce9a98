"""What the launch files have in common: their arguments, and the node of a wheelset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from ..errors import InputError, WheelsetTrackError
from ..inputs.schema import unknown

PACKAGE = "wheelset_track_sim"
Shown = Mapping[str, tuple[str, type, str]]
"""Launch arguments that set a parameter: its name, its type, what it does."""


class Program(NamedTuple):
    """What is started."""

    executable: str
    arguments: Shown


PARAMETERS: Shown = {
    "scenario": ("scenario", str, "name of a shipped scenario, or path of a scenario file"),
    "autostart": ("autostart", bool, "configure and activate at the start: true or false"),
    "real_time_factor": ("real_time_factor", float, "simulated time over elapsed time; 0 is as fast as possible"),
    "use_sim_time": ("use_sim_time", bool, "follow the time on /clock: true or false"),
    "record": ("record.on_start", bool, "record from the start of the run on: true or false"),
    "record_directory": ("record.directory", str, "folder in which bags are written, named by date, time and node"),
}
OF_REPLAY: Shown = {
    "bag": ("bag", str, "bag folder or .mcap file"),
    "rate": ("rate", float, "times as fast as recorded; 0 is as fast as possible"),
    "loop": ("loop", bool, "begin again at the end: true or false"),
    "start_offset": ("start_offset", float, "time after the first message at which the replay begins, s"),
    "duration": ("duration", float, "time of the bag after which the replay ends, s; 0 is all of it"),
    "delay": ("delay", float, "time that passes before the replay begins, s"),
    "wait": ("wait", float, "longest time to wait for a subscription before the replay begins, s"),
    "start_paused": ("start_paused", bool, "wait until the service resume is called: true or false"),
    "stamps": ("stamps", str, "original, or now: current time stamps"),
    "publish_clock": ("publish_clock", bool, "publish the time of the replay on /clock: true or false"),
    "prefix": ("prefix", str, "name of the node that topics get; ~ is this node's"),
    "use_sim_time": ("use_sim_time", bool, "follow the time on /clock: true or false"),
}
NODE, REPLAY = Program("node", PARAMETERS), Program("replay", OF_REPLAY)
BOGIE = ("leading", "trailing")
"""Wheelsets of a bogie."""
REJECTED = 2
"""Exit status of a node that cannot use its input."""
LEVELS = ("debug", "info", "warn", "error", "fatal")
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
        "params_file": (str(shipped), "parameter file; other arguments override it"),
        **{name: ("", f"{told}; empty: as in the parameter file") for name, (_, _, told) in program.arguments.items()},
        "log_level": ("info", f"least level of what is logged: {', '.join(LEVELS)}"),
    }

    def nodes(context: LaunchContext) -> list[Node]:
        def value(argument: str) -> str:
            return str(LaunchConfiguration(argument).perform(context))

        _check(program, value)
        found = list(wheelsets(value))
        return [_node(program, namespace, name, value, alone=len(found) == 1) for namespace, name in found]

    declared = [
        DeclareLaunchArgument(name, default_value=default, description=told)
        for name, (default, told) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])


def _check(program: Program, value: Value) -> None:
    """Raise InputError for the value of an argument that no node could use."""
    if not Path(value("params_file")).is_file():
        raise InputError(f"params_file = {value('params_file')} is not a file: give the path of a parameter file")
    if value("log_level").lower() not in LEVELS:
        raise InputError(unknown("log_level", value("log_level"), value("log_level"), LEVELS))
    for argument, (_, kind, _) in program.arguments.items():
        given = value(argument)
        if given and kind is bool and given.lower() not in ("true", "false"):
            raise InputError(f"{argument} = {given} is neither true nor false: give one of them")
        if given and kind is float:
            try:
                float(given)
            except ValueError:
                raise InputError(f"{argument} = {given} is not a number: give one") from None


def _ended(alone: bool, event: Any, context: LaunchContext) -> None:
    """End the launch with an error if a process rejected its input, or failed while no other one continues.

    ``launch`` would end with status 0. A process that ends by a signal, such as Ctrl-C, has a negative status.
    """
    if event.returncode == REJECTED or (alone and event.returncode > 0):
        raise WheelsetTrackError(f"{event.process_name} ended with status {event.returncode}: its last lines say why")


def _node(program: Program, namespace: str, name: str, value: Value, *, alone: bool) -> Node:
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
        on_exit=partial(_ended, alone),
    )
