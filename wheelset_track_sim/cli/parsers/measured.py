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
        "--unit", action="append", default=[], metavar="UNIT", help="of forces, stresses or time, instead of the file's"
    )
    command.add_argument(
        "--sign", choices=("compression", "tension"), default="compression", help="what a positive force in the file is"
    )
    command.add_argument(
        "--offset",
        action="append",
        default=[],
        metavar="[WHEEL=]FORCE",
        help="add a force, such as 98.1kN or wheel_1=98.1kN, where a signal has no static load",
    )
    command.add_argument(
        "--column", action="append", default=[], metavar="WHEEL=NAME", help="column that holds wheel_1 or wheel_2"
    )


def takes_place(command: Parser) -> None:
    """Add options that say where a measurement lies in the run."""
    command.add_argument(
        "--lag", type=float, metavar="S", help="zero of the measurement in the simulation, about, s or m"
    )
    command.add_argument(
        "--origin", metavar="TIME", help="time stamp in the file at which the simulation begins, about: s, or ISO 8601"
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
            raise InputError(f"--column {text!r} is not of the form wheel_1=NAME: give that of a column of the file")
        columns[wheel.strip()] = name.strip()
    return Reading(options.unit, options.sign, offsets, columns)
