"""Arguments of ``recover``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import takes_bag
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    recover = command(
        commands,
        "recover",
        "save what can be read of a damaged bag to a new one",
        uses=["damaged.mcap", "damaged.mcap --out whole.mcap"],
    )
    takes_bag(recover, ", which is not changed")
    recover.add_argument(
        "--out", type=Path, metavar="NEW", help="where to write the new bag (default: BAG_recovered beside it)"
    )
    recover.set_defaults(command=_recover)


def _recover(options: argparse.Namespace) -> int:
    from ..recover import run_recover

    return run_recover(options.bag, options.out)
