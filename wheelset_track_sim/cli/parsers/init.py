"""Arguments of ``init``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ...inputs import shipped
from ...runtime.output_files import require_folder
from .options import may_overwrite, takes_kind
from .parser import PROGRAM, Commands, command, completed


def add(commands: Commands) -> None:
    """Add the command."""
    init = command(
        commands,
        "init",
        "copy a shipped scenario, model, study, data set, detector, curve, mission or set of limits to edit it",
        uses=["scenario flat_fresh", "scenario damage_wheel_1 mine.yaml", "wheelset x40 my_wheelset.yaml"],
    )
    takes_kind(init)
    name = init.add_argument("name", metavar="NAME", help="its name, as list KIND prints it")
    completed(name, lambda parsed_args, **_: shipped.names(shipped.kind_of(parsed_args.kind)))
    init.add_argument("file", type=Path, nargs="?", metavar="FILE", help="where to write the copy (default: NAME.yaml)")
    may_overwrite(init)
    init.set_defaults(command=_init)


def _init(options: argparse.Namespace) -> int:
    from ..init import init

    if options.file is not None:
        require_folder(options.file)
    return init(options.kind, options.name, options.file, PROGRAM, overwrite=options.overwrite)
