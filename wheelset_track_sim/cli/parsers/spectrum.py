"""Arguments of ``spectrum``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import takes_bag, takes_json
from .parser import Amount, Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    spectrum = command(
        commands,
        "spectrum",
        "print frequencies, bands or orders of a signal in a bag",
        uses=[
            "run.mcap --signal wheel_1",
            "run.mcap --signal axle_box_acceleration/wheel_1 --third-octave",
            "run.mcap --signal A1_yy --orders --start 1 --json",
        ],
    )
    takes_bag(spectrum)
    spectrum.add_argument("--signal", required=True, metavar="NAME", help="such as wheel_1, A1_yy or strain/g/strain")
    kind = spectrum.add_mutually_exclusive_group()
    kind.add_argument("--third-octave", action="store_true", help="print levels in one-third-octave bands")
    kind.add_argument("--orders", action="store_true", help="print waves around the wheel")
    kind.add_argument("--average", action="store_true", help="print the mean over turns of the wheel, by its angle")
    spectrum.add_argument(
        "--resolution", action=Amount, unit="Hz", metavar="HZ", help="largest distance between frequencies"
    )
    spectrum.add_argument("--start", action=Amount, unit="s", metavar="TIME", help="simulated time of the first sample")
    spectrum.add_argument("--stop", action=Amount, unit="s", metavar="TIME", help="simulated time of the end")
    spectrum.add_argument("--out", type=Path, metavar="FILE", help="write all rows to .csv")
    takes_json(spectrum)
    spectrum.set_defaults(command=_spectrum)


def _spectrum(options: argparse.Namespace) -> int:
    from ..spectrum import run_spectrum

    return run_spectrum(options)
