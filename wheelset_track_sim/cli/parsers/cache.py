"""Arguments of ``cache``."""

from __future__ import annotations

import argparse

from .options import takes_json
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    cache = command(
        commands,
        "cache",
        "list or remove the models and compiled functions stored on disk",
        uses=["", "--clear", "--clear kernels"],
    )
    cache.add_argument(
        "--clear",
        nargs="?",
        const="all",
        metavar="KIND",
        help="remove all, or one kind; what is needed later is built again",
    )
    takes_json(cache)
    cache.set_defaults(command=_cache)


def _cache(options: argparse.Namespace) -> int:
    from ..cache import cache

    return cache(options.clear, json=options.json)
