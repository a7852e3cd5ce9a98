"""Arguments of ``explore``."""

from __future__ import annotations

import argparse

from ...inputs import shipped
from .options import takes_changes
from .parser import Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    explore = command(
        commands,
        "explore",
        "open a page with sliders for damage and run, which answers while you drag",
        "The page is served on this machine alone and needs no network. End it with Ctrl-C. Needs the extra explore.",
        uses=["", "flat_rounded --set 'speed=80 km/h'", "mine.yaml --port 8000 --no-browser"],
    )
    scenario = explore.add_argument(
        "scenario",
        nargs="?",
        default="damage_wheel_1",
        metavar="SCENARIO",
        help="a file, or a name that list scenarios prints (default: damage_wheel_1)",
    )
    completed(scenario, lambda **_: shipped.names("scenarios"))
    takes_changes(explore)
    explore.add_argument("--port", type=int, default=0, metavar="N", help="port of 127.0.0.1 (default: a free one)")
    explore.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")
    explore.set_defaults(command=_explore)


def _explore(options: argparse.Namespace) -> int:
    from ..explore import explore

    return explore(options.scenario, options.set, options.port, browser=not options.no_browser)
