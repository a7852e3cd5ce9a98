"""The command line ``wheelset-track-sim``: exit status 0, 1 failed, 2 bad input (one line on standard error)."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module

from ..runtime.memory import keep_freed_memory
from ..runtime.output_files import require_folder
from ..version import __version__
from .ending import FAILED, complain, status_of
from .parsers import (
    cache,
    compare,
    crack,
    dataset,
    demo,
    explore,
    fatigue,
    identify,
    info,
    init,
    listing,
    nodes,
    recover,
    report,
    resimulate,
    run,
    show,
    spectrum,
    stress,
    study,
    wayside,
)
from .parsers import (
    map as mapping,
)
from .parsers.nodes import OLD_RESIMULATE
from .parsers.parser import PROGRAM, Parser
from .warned import printed_warnings

COMMANDS = (
    *(listing.add, init.add, run.add, show.add, study.add, mapping.add, dataset.add),
    *(nodes.add_node, report.add, nodes.add_replay),
    *(nodes.add_get, nodes.add_set, nodes.add_call, nodes.add_echo, resimulate.add, recover.add, info.add),
    *(compare.add, stress.add, spectrum.add, fatigue.add, crack.add, wayside.add, identify.add),
    *(explore.add, cache.add, demo.add),
)
"""What adds a command each, in the order of the help."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    keep_freed_memory()
    # A node that is told to end before it has anything to close ends in order; a topic has no end of its own.
    proof = OLD_RESIMULATE in given
    interrupted = 0 if given[:1] in (["node"], ["replay"], ["echo"]) and not proof else FAILED
    return status_of(partial(_run_command, given), PROGRAM, interrupted)


def _run_command(given: list[str]) -> int:
    with printed_warnings(PROGRAM) as warnings:
        given = _renamed(given)
        if given[:1] == ["node"]:  # its arguments are those of every ROS node
            return nodes.run_node(given[1:])
        own, of_ros = _split(given) if given[:1] == ["replay"] else (given, [])
        parser = command_parser()
        if "_ARGCOMPLETE" in os.environ:  # a shell asks how the line can go on
            import_module("argcomplete").autocomplete(parser)
        options = parser.parse_args(own, argparse.Namespace(ros_arguments=of_ros, warnings=warnings))
        if getattr(options, "out", None) is not None:
            require_folder(options.out)
        command: Callable[[argparse.Namespace], int] = options.command
        return command(options)


def _renamed(given: list[str]) -> list[str]:
    """Arguments with the old name of a command replaced by the new one, which is reported."""
    if given[:1] != ["replay"] or OLD_RESIMULATE not in given:
        return given
    complain(PROGRAM, f"replay {OLD_RESIMULATE} is the old name of resimulate: use {PROGRAM} resimulate BAG", 0)
    return ["resimulate", *(each for each in given[1:] if each != OLD_RESIMULATE)]


def _split(given: Sequence[str]) -> tuple[list[str], list[str]]:
    """Our arguments, and the arguments of ROS, which are between ``--ros-args`` and ``--`` or the end."""
    ours: list[str] = []
    of_ros: list[str] = []
    inside = False
    for argument in given:
        inside = inside or argument == "--ros-args"
        (of_ros if inside else ours).append(argument)
        inside = inside and argument != "--"
    return ours, of_ros


def command_parser() -> Parser:
    """Parser of the whole command line."""
    parser = Parser(prog=PROGRAM, description="Wheel-rail impact loads and axle stresses of damaged wheels.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=Parser)
    for add in COMMANDS:
        add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
