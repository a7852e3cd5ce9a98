"""Arguments of ``show``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import may_overwrite, takes_changes, takes_shipped
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    show = command(
        commands,
        "show",
        "draw a scenario: treads, rails, profiles, supports and wheelset",
        uses=["mixed", "mine.yaml --out mine.pdf --overwrite"],
    )
    takes_shipped(show, "scenario")
    takes_changes(show)
    show.add_argument(
        "--out", type=Path, metavar="FILE", help="where to write the picture: .png, .svg or .pdf (default: NAME.png)"
    )
    may_overwrite(show)
    show.set_defaults(command=_show)


def _show(options: argparse.Namespace) -> int:
    from ..show import show

    return show(options.scenario, options.set, options.out, overwrite=options.overwrite)
