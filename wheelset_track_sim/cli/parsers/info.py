"""Arguments of ``info``."""

from __future__ import annotations

import argparse

from .options import takes_bag, takes_json
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    info = command(
        commands,
        "info",
        "print the contents of a bag: steps, revisions, peaks, gaps and files",
        uses=["run.mcap", "run.mcap --json"],
    )
    takes_bag(info)
    takes_json(info, "tables")
    info.set_defaults(command=_info)


def _info(options: argparse.Namespace) -> int:
    from ..info import info

    return info(options.bag, json=options.json)
