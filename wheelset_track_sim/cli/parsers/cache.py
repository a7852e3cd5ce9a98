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
        "models and compiled functions on disk: where, how many, how large, last use",
        uses=["", "--clear", "--clear kernels"],
    )
    cache.add_argument(
        "--clear",
        nargs="?",
        const="all",
        metavar="KIND",
        help="remove one kind, or all: models are built again when needed",
    )
    takes_json(cache)
    cache.set_defaults(command=_cache)


def _cache(options: argparse.Namespace) -> int:
    from ..cache import cache

    return cache(options.clear, json=options.json)
