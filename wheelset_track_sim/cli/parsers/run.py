"""Arguments of ``run``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ...errors import InputError
from ...inputs import shipped
from .options import takes_changes, takes_json, takes_limits, takes_shipped, takes_threshold
from .parser import Amount, Commands, command, completed

if TYPE_CHECKING:
    from ...bags.settings import RecordSettings
    from ...live.fatigue_watch import FatigueSettings
    from ...samples.impacts import ImpactSettings


def add(commands: Commands) -> None:
    """Add the command."""
    run = command(
        commands,
        "run",
        "simulate a scenario without ROS, as fast as possible",
        uses=[
            "damage_wheel_1",
            "flat_fresh --set 'speed=120 km/h' --set 'irregularities.0.length=40 mm'",
            "mine.yaml --duration '2 min' --out run.mcap --threshold '250 kN'",
            "mine.yaml --out run.csv",
            "flat_fresh --places 12",
        ],
    )
    takes_shipped(run, "scenario")
    takes_changes(run)
    run.add_argument(
        "--dynamics", metavar="NAME", help="causal: fast, the default of scenarios; paper: Green's functions as printed"
    )
    run.add_argument(
        "--duration",
        action=Amount,
        unit="s",
        metavar="TIME",
        help="simulated time, such as 10 or '10 s' (default: one turn of the wheel)",
    )
    run.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="write the run to a bag (.mcap, or a folder without a suffix) or a table (.csv, .parquet, .xlsx, .nc)",
    )
    run.add_argument("--split-size", type=int, metavar="BYTES", help="start another file of the bag at this size")
    run.add_argument(
        "--split-duration",
        action=Amount,
        unit="s",
        metavar="TIME",
        help="start another file of the bag after this simulated time",
    )
    run.add_argument(
        "--max-total-size", type=int, metavar="BYTES", help="remove the oldest files of the bag above this size"
    )
    run.add_argument(
        "--snapshots",
        action=Amount,
        unit="s",
        metavar="TIME",
        help="record only impacts, each from this time before it on",
    )
    takes_threshold(run, "the bag records an impact")
    curve = run.add_argument(
        "--fatigue", metavar="CURVE", help="record the fatigue of the axle by this S-N curve, once a second"
    )
    completed(curve, lambda **_: shipped.names("woehler"))
    takes_limits(run)
    run.add_argument(
        "--places",
        type=int,
        default=1,
        metavar="N",
        help="also simulate N places of the bay at which the damage meets the rail, and print the extremes over them",
    )
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
        limits=options.limits,
        places=options.places,
        fatigue=_fatigue(options),
        warnings=options.warnings,
    )


def _fatigue(options: argparse.Namespace) -> FatigueSettings | None:
    """How fatigue is counted; InputError without a bag."""
    from ...fatigue.curve import load_curve
    from ...live.fatigue_watch import FatigueSettings

    if options.fatigue is None:
        return None
    if options.out is None:
        raise InputError("--fatigue applies to a recording: give --out as well, or use the command fatigue")
    return FatigueSettings(load_curve(options.fatigue), "axle")


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
            raise InputError(f"--{option.replace('_', '-')} applies to a recording: give --out as well")
        return None, None
    try:
        settings = RecordSettings(CONTINUOUS if options.snapshots is None else SNAPSHOT, **given)
    except InputError as refusal:
        name, _, rest = str(refusal).partition(" ")
        raise InputError(f"--{named[name].replace('_', '-')} {rest}") from None
    return settings, None if options.threshold is None else ImpactSettings(options.threshold)
