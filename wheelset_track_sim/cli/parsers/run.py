"""Arguments of ``run``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError
from .options import takes_changes, takes_json, takes_shipped, takes_threshold
from .parser import Commands, command

if TYPE_CHECKING:
    from ...bags.settings import RecordSettings
    from ...samples.impacts import ImpactSettings


def add(commands: Commands) -> None:
    """Add the command."""
    run = command(
        commands,
        "run",
        "simulate without ROS, as fast as possible",
        uses=[
            "damage_wheel_1",
            "flat_fresh --set 'speed=120 km/h' --set 'irregularities.0.length=40 mm'",
            "mine.yaml --duration 2 --out run.mcap",
            "mine.yaml --out run.csv",
        ],
    )
    takes_shipped(run, "scenario")
    takes_changes(run)
    run.add_argument("--dynamics", help="causal (which streams) or paper (Green's functions as printed)")
    run.add_argument("--duration", type=float, metavar="S", help="simulated time (default: one turn of the wheel)")
    run.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="keep the run: a bag (FILE.mcap, or a folder without suffix), or a table (.csv, .parquet, .xlsx, .nc)",
    )
    run.add_argument("--split-size", type=int, metavar="BYTES", help="size at which the bag goes on in another file")
    run.add_argument("--split-duration", type=float, metavar="S", help="time of the run after which it does")
    run.add_argument("--max-total-size", type=int, metavar="BYTES", help="above it the oldest files are removed")
    run.add_argument(
        "--snapshots", type=float, metavar="S", help="record what is around impacts only, each from S before it"
    )
    takes_threshold(run, " in the bag")
    takes_json(run)
    run.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    from ..run import run

    changes = [*options.set, *([f"dynamics={options.dynamics}"] if options.dynamics else [])]
    settings, impacts = _recorded(options)
    return run(
        options.scenario,
        changes,
        options.duration,
        options.out,
        json=options.json,
        settings=settings,
        impacts=impacts,
        warnings=options.warnings,
    )


def _recorded(options: argparse.Namespace) -> tuple[RecordSettings | None, ImpactSettings | None]:
    """How a run is recorded; InputError names the option."""
    from ...bags.settings import CONTINUOUS, SNAPSHOT, RecordSettings
    from ...samples.impacts import ImpactSettings

    named = {
        "max_size": "split_size",
        "max_duration": "split_duration",
        "max_total_size": "max_total_size",
        "snapshot_duration": "snapshots",
    }
    given = {name: value for name, option in named.items() if (value := getattr(options, option)) is not None}
    if options.out is None:
        for option in [*(named[name] for name in given), *(["threshold"] if options.threshold is not None else [])]:
            raise InputError(f"--{option.replace('_', '-')} is of a bag: give --out, too")
        return None, None
    try:
        settings = RecordSettings(CONTINUOUS if options.snapshots is None else SNAPSHOT, **given)
    except InputError as refusal:
        name, _, rest = str(refusal).partition(" ")
        raise InputError(f"--{named[name].replace('_', '-')} {rest}") from None
    return settings, None if options.threshold is None else ImpactSettings(options.threshold)
