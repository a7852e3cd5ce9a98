"""Arguments of ``study``."""

from __future__ import annotations

import argparse
from pathlib import Path

from .options import takes_changes, takes_shipped
from .parser import Commands, command


def add(commands: Commands) -> None:
    """Add the command."""
    study = command(
        commands,
        "study",
        "a parameter study: runs, figures, tables, summary",
        uses=["load_cases", "depth --dynamics paper --workers 2", "mine.yaml --out results/mine"],
    )
    takes_shipped(study, "study", ", or all of these")
    study.add_argument(
        "--out", type=Path, metavar="DIR", help="folder of the results (default: results/STUDY-DYNAMICS)"
    )
    takes_changes(study, "change a key in all runs")
    study.add_argument("--dynamics", help="causal or paper")
    study.add_argument("--workers", type=int, metavar="N", help="processes on this machine (default: one a core)")
    study.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786, does the runs"
    )
    study.add_argument("--parquet", action="store_true", help="write tables as Parquet, too (extra analysis)")
    study.set_defaults(command=_study)


def _study(options: argparse.Namespace) -> int:
    from ...studies.conduct import Resources
    from ..study import study

    changes = [*options.set, *([f"dynamics={options.dynamics}"] if options.dynamics else [])]
    resources = Resources(options.workers, options.scheduler)
    return study(options.study, changes, options.out, resources, parquet=options.parquet)
