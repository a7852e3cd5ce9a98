"""Options of commands that read measurements."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ...errors import InputError
from .parser import Parser

if TYPE_CHECKING:
    from ...twin.measured import Matching, Reading


def takes_measured(command: Parser) -> None:
    """Add options that say how to read a measurement."""
    command.add_argument(
        "--unit",
        action="append",
        default=[],
        metavar="UNIT",
        help="unit of forces, stresses or time, if the file does not name it; repeat the option for more",
    )
    command.add_argument(
        "--sign",
        choices=("compression", "tension"),
        default="compression",
        help="meaning of a positive force in the file (default: compression)",
    )
    command.add_argument(
        "--offset",
        action="append",
        default=[],
        metavar="[WHEEL=]FORCE",
        help="static load to add to forces measured without it, such as '98.1 kN' or 'wheel_1=98.1 kN'",
    )
    command.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="WHEEL=NAME",
        help="name of the column that holds a wheel, such as wheel_1=force_right",
    )


def takes_place(command: Parser) -> None:
    """Add options that say where a measurement lies in the run."""
    command.add_argument(
        "--lag",
        type=float,
        metavar="S",
        help="approximate place of the start of the measurement in the run, s or m, if it is ambiguous",
    )
    command.add_argument(
        "--origin", metavar="TIME", help="approximate time stamp in the file at which the run begins: s, or ISO 8601"
    )


def matching_of(options: argparse.Namespace) -> Matching:
    """Where the measurement lies, as the options say."""
    from ...inputs.table_rows import seconds_of
    from ...twin.measured import Matching

    given = {"lag": options.lag, "threshold": options.threshold}
    if options.origin is not None:
        given["origin"] = float(seconds_of(options.origin, "--origin"))
    return Matching(**{name: value for name, value in given.items() if value is not None})


def reading_of(options: argparse.Namespace) -> Reading:
    """How to read the measurement, as the options say."""
    from ...inputs.amounts import amount
    from ...twin.measured import Reading
    from ...twin.measured.measurement import WHEELS

    offsets: dict[str, float] = {}
    for text in options.offset:
        wheel, equals, force = text.rpartition("=")
        value = amount(force, "N", "--offset")
        offsets |= {wheel.strip(): value} if equals else dict.fromkeys(WHEELS, value)
    columns = {}
    for text in options.column:
        wheel, equals, name = text.partition("=")
        if not equals:
            raise InputError(
                f"--column {text!r} does not have the form WHEEL=NAME: give, for example, wheel_1=force_right"
            )
        columns[wheel.strip()] = name.strip()
    return Reading(options.unit, options.sign, offsets, columns)
