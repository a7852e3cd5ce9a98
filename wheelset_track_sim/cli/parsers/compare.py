"""Arguments of ``compare``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .measured import matching_of, reading_of, takes_measured, takes_place
from .options import takes_bag, takes_json, takes_threshold
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    compare = command(
        commands,
        "compare",
        "compare a bag with measured wheel forces or axle stresses",
        uses=["run.mcap wayside.csv", "run.mcap wayside.csv --unit kN --offset 'wheel_1=10 t'"],
    )
    takes_bag(compare)
    compare.add_argument("measured", type=Path, metavar="FILE", help="the measurement: a text file or a bag")
    takes_place(compare)
    takes_measured(compare)
    takes_threshold(compare)
    takes_json(compare, "tables")
    compare.set_defaults(command=_compare)


def _compare(options: argparse.Namespace) -> int:
    from ..compare import compared

    return compared(
        options.bag,
        options.measured,
        matching_of(options),
        reading_of(options),
        json=options.json,
        warnings=options.warnings,
    )
