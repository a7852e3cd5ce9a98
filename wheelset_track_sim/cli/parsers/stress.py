"""Arguments of ``stress``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .measured import reading_of, takes_measured
from .options import takes_json
from .parser import Amount, Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    stress = command(
        commands,
        "stress",
        "compute axle stresses from measured wheel forces",
        uses=["wayside.csv --wheelset trailer", "wayside.csv --speed '90 km/h' --nodes A1,B1 --out stress.csv"],
    )
    stress.add_argument(
        "forces",
        type=Path,
        metavar="FORCES",
        help="a text file with the forces of both wheels over time or position, or a bag",
    )
    takes_measured(stress)
    names = ", ".join(shipped.names("wheelsets"))
    stress.add_argument("--wheelset", default="x40", help=f"a file, or one of {names} (default: x40)")
    stress.add_argument("--nodes", metavar="A1,B1", help="stress nodes, with commas (default: all of the wheelset)")
    stress.add_argument(
        "--speed",
        action=Amount,
        unit="m/s",
        metavar="SPEED",
        help="running speed, such as '90 km/h': needed for forces over position, and for --out FILE.mcap",
    )
    stress.add_argument("--own-weight", action="store_true", help="add the stress caused by the weight of the wheelset")
    stress.add_argument(
        "--out", type=Path, metavar="FILE", help="write the stresses to .csv, or forces and stresses to .mcap"
    )
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
