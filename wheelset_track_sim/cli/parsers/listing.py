"""Arguments of ``list``."""

from __future__ import annotations

import argparse

from .options import takes_json, takes_kind
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    listing = command(
        commands,
        "list",
        "list the shipped scenarios, models, studies, data sets, detectors, S-N curves, missions and limits",
        uses=["", "scenarios", "track --json"],
    )
    takes_kind(listing, nargs="?", default=None)
    takes_json(listing, "tables")
    listing.set_defaults(command=_list)


def _list(options: argparse.Namespace) -> int:
    from ..listing import listed

    return listed(options.kind, json=options.json)
