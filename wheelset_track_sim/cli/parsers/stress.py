"""Arguments of ``stress``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .measured import reading_of, takes_measured
from .options import takes_json
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    stress = command(
        commands,
        "stress",
        "axle stresses from wheel forces alone",
        uses=["wayside.csv --wheelset trailer", "wayside.csv --speed 25 --nodes A1,B1 --out stress.csv"],
    )
    stress.add_argument("forces", type=Path, metavar="FORCES", help="text file: both forces over time or position")
    takes_measured(stress)
    names = ", ".join(shipped.names("wheelsets"))
    stress.add_argument("--wheelset", default="x40", help=f"a file, or one of {names} (default: x40)")
    stress.add_argument("--nodes", metavar="A1,B1", help="stress nodes (default: all of the wheelset)")
    stress.add_argument("--speed", type=float, metavar="V", help="m/s, for forces over the position and for bags")
    stress.add_argument("--own-weight", action="store_true", help="add the stress of the wheelset's own weight")
    stress.add_argument("--out", type=Path, metavar="FILE", help="write stresses as .csv, or all as .mcap")
    takes_json(stress)
    stress.set_defaults(command=_stress)


def _stress(options: argparse.Namespace) -> int:
    from ..stress import stress

    nodes = [name.strip() for name in options.nodes.split(",")] if options.nodes else None
    return stress(
        options.forces,
        options.wheelset,
        nodes,
        options.speed,
        options.out,
        reading_of(options),
        own_weight=options.own_weight,
        json=options.json,
        warnings=options.warnings,
    )
