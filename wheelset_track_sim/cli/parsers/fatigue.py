"""Arguments of ``fatigue``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .options import takes_changes, takes_json
from .parser import Amount, Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    fatigue = command(
        commands,
        "fatigue",
        "count the stress cycles of the turning axle, and estimate its damage",
        "Ratios to the undamaged axle come first; absolute damage depends on the S-N curve, whose source is printed.",
        uses=[
            "damage_wheel_1",
            "flat_rounded --set 'speed=80 km/h' --distance '1.63 km'",
            "run.mcap --curve my_curve.yaml --json",
            "press_fit --criterion assumed_findley",
        ],
    )
    run = fatigue.add_argument(
        "run", metavar="SCENARIO|BAG", help="a scenario file, a name that list scenarios prints, or a bag at full rate"
    )
    completed(run, lambda prefix, **_: [*shipped.names("scenarios"), *map(str, Path().glob(f"{prefix}*"))])
    takes_changes(fatigue)
    curve = fatigue.add_argument(
        "--curve",
        default="assumed_body",
        metavar="CURVE",
        help="S-N curve: a file, or a name that list woehler prints (default: assumed_body)",
    )
    completed(curve, lambda **_: shipped.names("woehler"))
    fatigue.add_argument(
        "--distance",
        action=Amount,
        unit="m",
        metavar="DISTANCE",
        help="how far to run (default: 500 m), or how much of a bag to count (default: all)",
    )
    fatigue.add_argument(
        "--angles", type=int, default=36, metavar="NUMBER", help="points around the axle (default: 36)"
    )
    fatigue.add_argument(
        "--gate", action=Amount, unit="Pa", metavar="STRESS", help="merge ranges up to this (default: '0.05 MPa')"
    )
    criterion = fatigue.add_argument(
        "--criterion",
        metavar="CRITERION",
        help="also the usage of the fatigue limit by Findley's criterion: a file, or a name that list criteria prints",
    )
    completed(criterion, lambda **_: shipped.names("criteria"))
    fatigue.add_argument(
        "--service",
        action=Amount,
        unit="m",
        metavar="DISTANCE",
        help="also the probability that an axle fails within it, such as '1e6 km'",
    )
    takes_json(fatigue)
    fatigue.set_defaults(command=_fatigue)


def _fatigue(options: argparse.Namespace) -> int:
    from ..fatigue import fatigue

    return fatigue(
        options.run,
        options.set,
        options.curve,
        options.distance,
        angles=options.angles,
        gate=options.gate,
        criterion_name=options.criterion,
        service=options.service,
        json=options.json,
        warnings=options.warnings,
    )
