"""Options that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...inputs import shipped
from ...verdict.limit_set import DEFAULT_LIMITS
from .parser import Amount, Parser, completed

if TYPE_CHECKING:
    from ...studies.conduct import Resources


def takes_bag(command: Parser, and_then: str = "") -> None:
    """Add the bag that the command reads."""
    command.add_argument("bag", type=Path, metavar="BAG", help=f"an .mcap file or a bag folder{and_then}")


def takes_changes(command: Parser, what: str = "change a key of the scenario, such as 'speed=100 km/h'") -> None:
    """Add ``--set``."""
    keys = "bare numbers are SI; docs/reference/scenarios.md lists all keys; repeat the option for more"
    command.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=f"{what}; {keys}")


def takes_threshold(command: Parser, event: str = "an impact begins") -> None:
    """Add ``--threshold``."""
    what = f"contact force above which {event} (default: '200 kN')"
    command.add_argument("--threshold", action=Amount, unit="N", metavar="FORCE", help=what)


def takes_limits(command: Parser) -> None:
    """Add ``--limits``."""
    limits = command.add_argument(
        "--limits",
        default=DEFAULT_LIMITS,
        metavar="LIMITS",
        help=f"limits for the verdict: a file, a name that list limits prints, or none (default: {DEFAULT_LIMITS})",
    )
    completed(limits, lambda prefix, **_: [*shipped.names("limits"), *map(str, Path().glob(f"{prefix}*"))])


def takes_json(command: Parser, instead_of: str = "a table") -> None:
    """Add ``--json``."""
    command.add_argument("--json", action="store_true", help=f"print one JSON object instead of {instead_of}")


def may_overwrite(command: Parser) -> None:
    """Add ``--overwrite``."""
    command.add_argument("--overwrite", action="store_true", help="replace files that exist already")


def takes_shipped(command: Parser, name: str, further: str = "") -> None:
    """Add a file or the name of a shipped one; shells complete both."""
    kind = shipped.kind_of(name)
    what = f"a file, or a name that list {kind} prints{further}"
    named = command.add_argument(name, metavar=name.upper(), help=what)
    completed(named, lambda prefix, **_: [*shipped.names(kind), *map(str, Path().glob(f"{prefix}*"))])


def takes_resources(command: Parser) -> None:
    """Add ``--workers`` and ``--scheduler``."""
    command.add_argument(
        "--workers", type=int, metavar="N", help="number of processes on this machine (default: one per core)"
    )
    command.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on a Dask cluster; the address of its scheduler, such as tcp://host:8786",
    )


def resources_of(options: argparse.Namespace) -> Resources:
    """Where runs are simulated, as the options say."""
    from ...studies.conduct import Resources

    return Resources(options.workers, options.scheduler)


def takes_forms(command: Parser) -> None:
    """Add ``--parquet``, ``--netcdf`` and ``--zarr``: further forms of results."""
    for form, what in (
        ("parquet", "the tables as Parquet"),
        ("netcdf", "all outputs over their axes as NetCDF"),
        ("zarr", "all outputs over their axes as Zarr"),
    ):
        text = f"also write {what} (needs the extra analysis)"
        command.add_argument(f"--{form}", action="append_const", const=form, dest="forms", default=[], help=text)


def takes_kind(command: Parser, **options: Any) -> None:
    """Add the kind of a shipped file."""
    kinds = [shipped.singular(kind) for kind in shipped.kinds()]
    kind = command.add_argument("kind", metavar="KIND", help=f"one of {', '.join(kinds)}", **options)
    completed(kind, lambda **_: kinds)
