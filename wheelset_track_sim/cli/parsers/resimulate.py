"""Arguments of ``resimulate``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import takes_bag, takes_changes, takes_json
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    resimulate = command(
        commands,
        "resimulate",
        "simulate the run of a bag again and compare it with the recording",
        "Each change takes effect at its recorded step. Without --set, the same software on the same processor "
        "reproduces every force and stress bit for bit. The exit status is 1 if numbers differ although settings, "
        "versions, processor and models are the same and all inputs are known.",
        uses=["run.mcap", "run.mcap --set 'wheel_1.damage.h=1 mm'"],
    )
    takes_bag(resimulate)
    takes_changes(resimulate, "set a key throughout the run, such as 'wheel_1.damage.h=1 mm'")
    resimulate.add_argument("--out", type=Path, metavar="BAG", help="record the new run: FILE.mcap, or a bag folder")
    resimulate.add_argument(
        "--most-steps",
        type=int,
        metavar="N",
        help="most steps to simulate for which the bag has no samples, such as those before it (default: 1e8)",
    )
    takes_json(resimulate)
    resimulate.set_defaults(command=_resimulate)


def _resimulate(options: argparse.Namespace) -> int:
    from ..resimulate import run_resimulate

    return run_resimulate(options.bag, options.set, options.out, options.most_steps, json=options.json)
