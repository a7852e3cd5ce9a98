"""Arguments of ``dataset``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...errors import InputError
from ...inputs import shipped
from .options import resources_of, takes_json, takes_resources
from .parser import Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    dataset = command(
        commands,
        "dataset",
        "write a labelled data set of signals of damaged wheels",
        "A data set that was stopped goes on where it was, when the same command runs again.",
        uses=[
            "damaged_wheels --samples 1000 --seed 1 --out damage.zarr",
            "mine.yaml --samples 100000 --seed 1 --out damage.zarr --scheduler tcp://host:8786",
            "damage.zarr --rebuild 42",
        ],
    )
    spec = dataset.add_argument(
        "spec",
        metavar="SPEC",
        help="a file, or a name that list datasets prints; with --rebuild the folder of a data set",
    )
    completed(spec, lambda prefix, **_: [*shipped.names("datasets"), *map(str, Path().glob(f"{prefix}*"))])
    dataset.add_argument("--samples", type=int, metavar="N", help="number of samples; needed without --rebuild")
    dataset.add_argument("--seed", type=int, default=1, metavar="N", help="seed of all that is drawn (default: 1)")
    dataset.add_argument("--out", type=Path, metavar="DIR", help="folder of the data set, such as damage.zarr")
    dataset.add_argument(
        "--rebuild", type=int, metavar="SAMPLE", help="simulate one sample again from its label, and compare all bits"
    )
    takes_resources(dataset)
    takes_json(dataset)
    dataset.set_defaults(command=_dataset)


def _dataset(options: argparse.Namespace) -> int:
    from ..dataset import dataset, rebuilt

    if options.rebuild is not None:
        return rebuilt(Path(options.spec), options.rebuild, json=options.json)
    for name in ("samples", "out"):
        if getattr(options, name) is None:
            raise InputError(f"--{name} is missing: give --samples N and --out DIR, or --rebuild SAMPLE")
    return dataset(options.spec, options.out, options.samples, options.seed, resources_of(options), json=options.json)
