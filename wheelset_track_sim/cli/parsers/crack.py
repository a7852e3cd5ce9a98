"""Arguments of ``crack``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .options import takes_changes, takes_json
from .parser import Amount, Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    crack = command(
        commands,
        "crack",
        "estimate how far an axle with a crack can run, as a band",
        "The band is of the scatter of law, shape and residual stress, whose source is printed.",
        uses=[
            "damage_wheel_1 --depth '2 mm' --growth assumed_steel",
            "flat_rounded --set 'speed=80 km/h' --depth '3 mm' --growth my_steel.yaml",
            "run.mcap --depth '2 mm' --growth my_steel.yaml --json",
        ],
    )
    run = crack.add_argument(
        "run", metavar="SCENARIO|BAG", help="a scenario file, a name that list scenarios prints, or a bag at full rate"
    )
    completed(run, lambda prefix, **_: [*shipped.names("scenarios"), *map(str, Path().glob(f"{prefix}*"))])
    takes_changes(crack)
    growth = crack.add_argument(
        "--growth",
        required=True,
        metavar="LAW",
        help="law of crack growth with its source: a file, or a name that list cracks prints",
    )
    completed(growth, lambda **_: shipped.names("cracks"))
    crack.add_argument(
        "--depth", action=Amount, unit="m", required=True, metavar="DEPTH", help="depth of the crack, such as '2 mm'"
    )
    crack.add_argument(
        "--inspections",
        type=int,
        default=2,
        metavar="NUMBER",
        help="inspections before the crack is critical in the fast case (default: 2)",
    )
    crack.add_argument(
        "--distance",
        action=Amount,
        unit="m",
        metavar="DISTANCE",
        help="how far to run (default: 500 m), or how much of a bag to count (default: all)",
    )
    crack.add_argument("--angles", type=int, default=36, metavar="NUMBER", help="points around the axle (default: 36)")
    takes_json(crack)
    crack.set_defaults(command=_crack)


def _crack(options: argparse.Namespace) -> int:
    from ..crack import crack

    return crack(
        options.run,
        options.set,
        options.growth,
        options.depth,
        options.distance,
        angles=options.angles,
        inspections=options.inspections,
        json=options.json,
        warnings=options.warnings,
    )
