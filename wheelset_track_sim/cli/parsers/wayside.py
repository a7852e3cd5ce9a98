"""Arguments of ``wayside``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .options import may_overwrite, takes_changes, takes_json
from .parser import Amount, Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    wayside = command(
        commands,
        "wayside",
        "show what detectors beside the track read, beside the true contact forces",
        "Without --detector it reads the detectors of the scenario, or a shear_array if there are none.",
        uses=[
            "damage_wheel_1",
            "flat_fresh --detector shear_single --at '3.0 m' --out flat.png",
            "run.mcap --detector my_detector.yaml --json",
        ],
    )
    run = wayside.add_argument(
        "run", metavar="SCENARIO|BAG", help="a scenario file, a name that list scenarios prints, or a bag at full rate"
    )
    completed(run, lambda prefix, **_: [*shipped.names("scenarios"), *map(str, Path().glob(f"{prefix}*"))])
    takes_changes(wayside)
    detector = wayside.add_argument(
        "--detector",
        action="append",
        default=[],
        metavar="DETECTOR",
        help="a file, or a name that list detectors prints; repeat the option for more",
    )
    completed(detector, lambda prefix, **_: [*shipped.names("detectors"), *map(str, Path().glob(f"{prefix}*"))])
    wayside.add_argument(
        "--at",
        action=Amount,
        unit="m",
        metavar="POSITION",
        help="where the detectors of --detector stand (default: where angle 0 of the treads meets the rail)",
    )
    wayside.add_argument(
        "--out", type=Path, metavar="FILE", help="write what the channels read: .csv, or a picture .png, .svg, .pdf"
    )
    may_overwrite(wayside)
    takes_json(wayside)
    wayside.set_defaults(command=_wayside)


def _wayside(options: argparse.Namespace) -> int:
    from ..wayside import wayside

    return wayside(
        options.run,
        options.set,
        options.detector,
        options.at,
        options.out,
        overwrite=options.overwrite,
        json=options.json,
        warnings=options.warnings,
    )
