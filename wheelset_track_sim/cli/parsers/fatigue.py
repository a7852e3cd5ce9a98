"""Arguments of ``fatigue``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import InputError
from ...inputs import shipped
from ...runtime.output_files import require_folder
from .options import takes_changes, takes_json
from .parser import Amount, Commands, command, completed

if TYPE_CHECKING:
    from ..fatigue_ledger import Keep


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
            "monday.mcap tuesday.mcap --ledger axle_7.ledger --axle 'axle 7'",
            "damage_wheel_1 --mission intercity --distance '30000 km'",
            "press_fit --criterion assumed_findley",
        ],
    )
    run = fatigue.add_argument(
        "run",
        nargs="+",
        metavar="SCENARIO|BAG|LEDGER",
        help="a scenario file, a name that list scenarios prints, a bag at full rate, or a .ledger; several add up",
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
        help="how far to run (default: 500 m), how much of a bag to count (default: all), or the length of a mission",
    )
    fatigue.add_argument(
        "--angles", type=int, default=36, metavar="NUMBER", help="points around the axle (default: 36)"
    )
    fatigue.add_argument(
        "--gate", action=Amount, unit="Pa", metavar="STRESS", help="merge ranges up to this (default: '0.05 MPa')"
    )
    fatigue.add_argument(
        "--ledger", type=Path, metavar="FILE.ledger", help="add the runs to this file, which is made if it is missing"
    )
    fatigue.add_argument("--axle", metavar="NAME", help="identity of the axle in the ledger")
    fatigue.add_argument(
        "--run",
        dest="run_name",
        metavar="NAME",
        help="identity of the run in the ledger (default: by its inputs)",
    )
    fatigue.add_argument(
        "--mark",
        action=Amount,
        unit="rad",
        default=0.0,
        metavar="ANGLE",
        help="angle of the axle's mark from the top when angle 0 of the treads meets the rail (default: 0)",
    )
    fatigue.add_argument(
        "--checkpoint", action=Amount, unit="m", metavar="DISTANCE", help="keep the count this often (default: '5 km')"
    )
    mission = fatigue.add_argument(
        "--mission",
        metavar="MISSION",
        help="speeds, loads and growing damage: a file, or a name that list missions prints",
    )
    completed(mission, lambda **_: shipped.names("missions"))
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
    from ..fatigue import fatigue, is_bag
    from ..fatigue_ledger import fatigue_of_several, is_ledger
    from ..fatigue_mission import fatigue_of_mission

    keep = _keep(options)
    how: Any = {name: getattr(options, name) for name in ("angles", "gate", "json", "warnings")}
    one = options.run[0] if len(options.run) == 1 and not is_ledger(options.run[0]) else None
    common = options.set, options.curve, options.distance
    of_one = {"criterion": options.criterion, "service": options.service}
    if one is None or keep is not None or options.mission is not None:
        for option, given in of_one.items():
            if given is not None:
                raise InputError(f"--{option} is of one run alone: leave out --{option}, or give one run and no more")
    if options.mission is not None:
        if one is None or is_bag(one) or keep is not None or options.mark:
            raise InputError(
                "--mission takes one scenario and estimates: leave out --ledger and --mark, or the mission"
            )
        return fatigue_of_mission(one, *common, options.mission, **how)
    if one is not None and keep is None:
        return fatigue(
            one, *common, mark=options.mark, criterion_name=options.criterion, service=options.service, **how
        )
    return fatigue_of_several(options.run, *common, mark=options.mark, keep=keep, **how)


def _keep(options: argparse.Namespace) -> Keep | None:
    """How runs go into a ledger; InputError names the option."""
    from ...fatigue.ledger import SUFFIX
    from ..fatigue_ledger import Keep, is_ledger

    if options.ledger is None:
        for option in ("axle", "run_name", "checkpoint"):
            if getattr(options, option) is not None:
                raise InputError(f"--{option.partition('_')[0]} applies to a ledger: give --ledger as well")
        return None
    if options.ledger.suffix != SUFFIX:
        raise InputError(f"--ledger {options.ledger} is no name of a ledger: give one that ends in {SUFFIX}")
    if options.axle is None and not all(map(is_ledger, options.run)):
        raise InputError("--axle is missing: name the axle of these runs, such as --axle 'axle 7'")
    require_folder(options.ledger)
    checkpoint = {} if options.checkpoint is None else {"checkpoint": options.checkpoint}
    return Keep(options.ledger, options.axle or "", options.run_name, **checkpoint)
