"""Arguments of ``map``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import resources_of, takes_changes, takes_forms, takes_resources, takes_shipped
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    map_ = command(
        commands,
        "map",
        "draw a result over two keys of a scenario, with contours and limits",
        "An axis is a range, KEY=LOW..HIGH, or a distribution: KEY=uniform(LOW, HIGH), KEY=normal(MEAN, DEVIATION) or "
        "KEY=lognormal(MEAN, DEVIATION). Both axes are of one kind.",
        uses=[
            "damage_wheel_1 --x speed=40..200km/h --y irregularities.0.h=0..3mm --limit '350 kN'",
            "flat_fresh --x speed=40..160km/h --y axle_load=10..25t --quantity A1.max_principal --points 9x7",
            "flat_fresh --x 'speed=normal(80 km/h, 8 km/h)' --y 'irregularities.0.length=uniform(20 mm, 60 mm)'",
        ],
    )
    takes_shipped(map_, "scenario")
    for axis, where in (("--x", "to the right"), ("--y", "upwards")):
        map_.add_argument(axis, required=True, metavar="KEY=RANGE", help=f"what is varied {where}")
    map_.add_argument(
        "--quantity",
        default="max_force",
        metavar="NAME",
        help="output of a study, such as wheels.wheel_2.max_force, or its end, such as A1.max_principal (default: "
        "max_force, of wheel 1)",
    )
    map_.add_argument(
        "--points", default="13", metavar="N|NxM", help="points along both ranges, or along each (default: 13)"
    )
    map_.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="VALUE",
        help="value at which a line is drawn, such as '350 kN'; repeat the option for more",
    )
    map_.add_argument("--draws", type=int, metavar="N", help="number of draws from distributions (default: 64)")
    map_.add_argument(
        "--method",
        metavar="NAME",
        help="how to draw: sobol (default), latin_hypercube, random, or saltelli, which gives sensitivities",
    )
    map_.add_argument("--seed", type=int, metavar="N", help="seed of the draws (default: 1)")
    takes_changes(map_)
    map_.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results (default: results/map-SCENARIO-X-Y)"
    )
    takes_resources(map_)
    takes_forms(map_)
    map_.set_defaults(command=_map)


def _map(options: argparse.Namespace) -> int:
    from ..map import map_

    sampling = {"count": options.draws, "method": options.method, "seed": options.seed}
    return map_(
        options.scenario,
        (options.x, options.y),
        options.points,
        options.quantity,
        options.limit,
        {key: value for key, value in sampling.items() if value is not None},
        options.set,
        options.out,
        resources_of(options),
        options.forms,
    )
