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
        "simulate the run of a bag again, with each change at its step, and compare it with the recording",
        "Without --set, every force and stress is the same to the last bit on the software and processor that recorded "
        "it. The exit status is 1 if numbers differ, and no setting, version, processor, model or unknown input is a "
        "reason.",
        uses=["run.mcap", "run.mcap --set 'wheel_1.damage.h=1 mm'"],
    )
    takes_bag(resimulate)
    takes_changes(resimulate, "set a key throughout the run, such as wheel_1.damage.h=0.001 or track.spacing=0.65")
    resimulate.add_argument("--out", type=Path, metavar="BAG", help="record the new run: FILE.mcap, or a bag folder")
    resimulate.add_argument(
        "--most-steps", type=int, metavar="N", help="steps without samples to simulate, as before the bag (1e8)"
    )
    takes_json(resimulate)
    resimulate.set_defaults(command=_resimulate)


def _resimulate(options: argparse.Namespace) -> int:
    from ..resimulate import run_resimulate

    return run_resimulate(options.bag, options.set, options.out, options.most_steps, json=options.json)
