"""Arguments of ``study``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import resources_of, takes_changes, takes_forms, takes_resources, takes_shipped
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    study = command(
        commands,
        "study",
        "run a parameter study and write its figures, tables and summary",
        uses=["load_cases", "depth --dynamics paper --workers 2", "mine.yaml --out results/mine"],
    )
    takes_shipped(study, "study", ", or all")
    study.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder of the results (default: results/STUDY-DYNAMICS); finished runs there are not repeated",
    )
    takes_changes(study, "change a key in all runs, such as 'speed=100 km/h'")
    study.add_argument("--dynamics", metavar="NAME", help="causal or paper, in all runs")
    study.add_argument(
        "--places",
        type=int,
        metavar="N",
        help="repeat each run with the damage meeting the rail at N places of the bay (default: what the study says)",
    )
    takes_resources(study)
    takes_forms(study)
    study.set_defaults(command=_study)


def _study(options: argparse.Namespace) -> int:
    from ..study import study

    changes = [*options.set, *([f"dynamics={options.dynamics}"] if options.dynamics else [])]
    return study(options.study, changes, options.out, resources_of(options), options.forms, places=options.places)
