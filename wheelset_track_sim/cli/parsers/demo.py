"""Arguments of ``demo``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    demo = command(
        commands,
        "demo",
        "stream, record and report the paper's Section 5.1 through the ROS 2 node",
        uses=["", "--out demo"],
    )
    demo.add_argument(
        "--out",
        type=Path,
        default=Path("demo"),
        metavar="DIR",
        help="folder of the bag, the page and the picture (default: demo)",
    )
    demo.set_defaults(command=_demo)


def _demo(options: argparse.Namespace) -> int:
    from ..demo import demo

    return demo(options.out)
