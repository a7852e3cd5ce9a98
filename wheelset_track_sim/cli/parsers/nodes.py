"""Arguments of ``replay``, and of ``get``, ``set``, ``call`` and ``echo``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...errors import InputError
from .options import takes_json
from .parser import PROGRAM, Amount, Commands, Parser, command, examples

NO_PARAMETERS = ("command", "ros_arguments", "warnings")
"""Options of ``replay`` that are no parameters of its node."""
OLD_RESIMULATE = "--simulate-again"
"""Option that made ``replay`` simulate a bag again."""


def add_node(commands: Commands) -> None:
    """Name the command in the list; ``run_node`` takes its arguments, which are those of every ROS node."""
    commands.add_parser("node", help="run the ROS 2 node; it takes the arguments of every ROS node", add_help=False)


def run_node(arguments: list[str]) -> int:
    """Run the node; returns the exit status."""
    from ..nodes import node

    return node(arguments)


def add_replay(commands: Commands) -> None:
    """Add the command ``replay``."""
    replay = commands.add_parser(
        "replay",
        help="play a bag on the topics on which it was recorded",
        usage="%(prog)s [OPTION ...] BAG [--ros-args -p NAME:=VALUE -r FROM:=TO ...]",
        description="Play a bag on the topics on which it was recorded, as a ROS 2 node. Each option is a parameter of "
        f"the node. To simulate the run again, use {PROGRAM} resimulate (formerly replay {OLD_RESIMULATE}).",
        epilog=examples("replay", ["run.mcap --rate 2 --loop", "run.mcap --ros-args -r __node:=replay"]),
    )
    replay.add_argument("bag", type=Path, nargs="?", metavar="BAG", help="an .mcap file or a bag folder")
    replay.add_argument(
        "--rate", type=float, metavar="R", help="pace as a multiple of real time (default: 1; 0: as fast as possible)"
    )
    replay.add_argument("--loop", action="store_true", default=None, help="start over at the end")
    replay.add_argument(
        "--start-offset", action=Amount, unit="s", metavar="TIME", help="skip this time at the beginning"
    )
    replay.add_argument("--duration", action=Amount, unit="s", metavar="TIME", help="stop after this time of the bag")
    replay.add_argument(
        "--delay", action=Amount, unit="s", metavar="TIME", help="wait at least this long before the first message"
    )
    replay.add_argument(
        "--wait",
        action=Amount,
        unit="s",
        metavar="TIME",
        help="wait at most this long for subscriptions before the first message (default: 2 s)",
    )
    replay.add_argument("--stamps", metavar="original|now", help="time stamps: as recorded (default), or those of now")
    replay.add_argument(
        "--publish-clock", action="store_true", default=None, help="publish the time of the replay on /clock"
    )
    replay.add_argument(
        "--prefix",
        metavar="NAME",
        help="node name that replaces the recorded one in topics; ~ is the name of this node",
    )
    replay.add_argument(
        "--start-paused", action="store_true", default=None, help="wait for a call of the service resume"
    )
    replay.set_defaults(command=_replay)


def _replay(options: argparse.Namespace) -> int:
    from ..nodes import replay

    parameters = {name: value for name, value in vars(options).items() if name not in NO_PARAMETERS}
    return replay(ros_arguments=options.ros_arguments, **parameters)


def add_get(commands: Commands) -> None:
    """Add the command ``get``."""
    get = command(
        commands,
        "get",
        "print parameters of a running node, without ros2",
        uses=["", "speed wheel_1.damage.h", "--node /train/w1 axle_load"],
    )
    get.add_argument("parameters", nargs="*", metavar="NAME", help="parameters to print (default: all)")
    takes_node(get)
    takes_json(get, "YAML")
    get.set_defaults(command=_get)


def _get(options: argparse.Namespace) -> int:
    from ..nodes import get

    return get(options.node, options.parameters, options.timeout, json=options.json)


def add_set(commands: Commands) -> None:
    """Add the command ``set``."""
    setting = command(
        commands,
        "set",
        "set parameters of a running node: all of them or none",
        uses=["'speed=120 km/h'", "wheel_1.damage.a=0.02 'wheel_1.damage.h=1 mm'"],
    )
    setting.add_argument(
        "changes", nargs="+", metavar="NAME=VALUE", help="new value in SI or with a unit, such as 'speed=100 km/h'"
    )
    takes_node(setting)
    setting.set_defaults(command=_set)


def _set(options: argparse.Namespace) -> int:
    from ..nodes import set_parameters

    return set_parameters(options.node, options.changes, options.timeout)


def add_call(commands: Commands) -> None:
    """Add the command ``call``."""
    call = command(
        commands,
        "call",
        "call a service of a running node",
        "The exit status is 1 if the service reports a failure.",
        uses=[
            "pause",
            "set_speed speed=30 acceleration=1",
            "set_tread_damage 'damage=[{wheel: 1, a: 0.02, b: 0.016, h: 0.001}]'",
        ],
    )
    call.add_argument(
        "service", metavar="SERVICE", help="name, such as pause or set_speed; docs/reference/interface.md lists all"
    )
    call.add_argument("fields", nargs="*", metavar="FIELD=VALUE", help="field of the request, as YAML, in SI")
    takes_node(call)
    takes_json(call, "YAML")
    call.set_defaults(command=_call)


def _call(options: argparse.Namespace) -> int:
    from ..nodes import call

    return call(options.node, options.service, options.fields, options.timeout, json=options.json)


def add_echo(commands: Commands) -> None:
    """Add the command ``echo``."""
    echo = command(
        commands,
        "echo",
        "print the messages of a topic of a running node until interrupted",
        uses=["summary", "state --count 1 --full", "contact_forces --json"],
    )
    echo.add_argument("topic", metavar="TOPIC", help="name, such as summary; docs/reference/interface.md lists all")
    echo.add_argument("--count", type=int, metavar="N", help="stop after N messages")
    echo.add_argument("--full", action="store_true", help="print all values of long lists, not their number and range")
    takes_node(echo)
    takes_json(echo, "YAML")
    echo.set_defaults(command=_echo)


def _echo(options: argparse.Namespace) -> int:
    from ..nodes import echo

    if options.count is not None and options.count < 1:
        raise InputError(f"--count {options.count} is out of range: give 1 or more")
    return echo(options.node, options.topic, options.count, options.timeout, json=options.json, full=options.full)


def takes_node(command: Parser) -> None:
    """Add the name of the running node, and how long to wait for it."""
    command.add_argument(
        "--node",
        default="wheelset_track_sim",
        metavar="NAME",
        help="the node, with its namespace (default: wheelset_track_sim)",
    )
    command.add_argument(
        "--timeout",
        action=Amount,
        unit="s",
        default=120.0,
        metavar="TIME",
        help="longest time to wait for an answer (default: '2 min'); a node that is not there is reported after 10 s",
    )
