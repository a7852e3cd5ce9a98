"""Arguments of ``report``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from .measured import matching_of, reading_of, takes_measured, takes_place
from .options import may_overwrite, takes_bag, takes_limits, takes_threshold
from .parser import Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    report = command(
        commands,
        "report",
        "write a page and a picture of a bag, and print a table",
        uses=[
            "run.mcap",
            "run.mcap --measured wayside.csv --out page.html",
            "run.mcap --fatigue assumed_body",
        ],
    )
    takes_bag(report)
    report.add_argument(
        "--out", type=Path, metavar="FILE.html", help="where to write the page (default: beside the bag)"
    )
    report.add_argument(
        "--picture",
        type=Path,
        metavar="FILE",
        help="where to write the picture: .png, .svg or .pdf (default: .png beside the page)",
    )
    takes_threshold(report)
    report.add_argument(
        "--measured", type=Path, metavar="FILE", help="measurement to show with the run: a text file or a bag"
    )
    takes_place(report)
    takes_measured(report)
    takes_limits(report)
    curve = report.add_argument(
        "--fatigue", metavar="CURVE", help="count fatigue by this S-N curve: a file, or a name that list woehler prints"
    )
    completed(curve, lambda **_: shipped.names("woehler"))
    may_overwrite(report)
    report.set_defaults(command=_report)


def _report(options: argparse.Namespace) -> int:
    from ...samples.impacts import ImpactSettings
    from ..report import report

    settings = None if options.threshold is None else ImpactSettings(options.threshold)
    return report(
        options.bag,
        options.out,
        settings,
        options.measured,
        matching_of(options),
        reading_of(options),
        picture=options.picture,
        overwrite=options.overwrite,
        limits=options.limits,
        curve=options.fatigue,
    )
