"""What the parsers of all commands are made of: help with examples, and errors in one line."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any, NoReturn, TypeAlias

from ...errors import InputError
from ...inputs.amounts import amount

PROGRAM = "wheelset-track-sim"
EXAMPLES = "examples:"


class Help(argparse.HelpFormatter):
    """Wraps descriptions, and keeps the lines of examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        if not text.startswith(EXAMPLES):
            return super()._fill_text(text, width, indent)
        return "\n".join(indent + line for line in text.splitlines())


class Parser(argparse.ArgumentParser):
    """Raises InputError for arguments that cannot be used."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=Help, **options)

    def error(self, message: str) -> NoReturn:
        """Raise InputError with the message, and with the help to read."""
        raise InputError(f"{message}: see {self.prog} --help")


class Amount(argparse.Action):
    """Takes a number of the SI unit ``unit``, or a text with another one; the value is in SI."""

    def __init__(self, *, unit: str, **options: Any) -> None:
        super().__init__(**options)
        self._unit = unit

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: Any = None
    ) -> None:
        """Store the value; raises InputError for what is not an amount."""
        setattr(namespace, self.dest, amount(values, self._unit, option_string or self.dest))


Commands: TypeAlias = "argparse._SubParsersAction[Parser]"


def command(commands: Commands, name: str, what: str, details: str = "", *, uses: Sequence[str]) -> Parser:
    """Parser of a command; ``what`` it does is one line in the list of commands, ``uses`` are arguments of examples."""
    description = f"{what[0].upper()}{what[1:]}. {details}".strip()
    return commands.add_parser(name, help=what, description=description, epilog=examples(name, uses))


def examples(name: str, uses: Sequence[str]) -> str:
    """Examples of a command, a line each."""
    return "\n".join([EXAMPLES, *(f"  {PROGRAM} {name} {use}".rstrip() for use in uses)])


def completed(argument: argparse.Action, completer: Callable[..., list[str]]) -> None:
    """Let shells complete an argument."""
    argument.completer = completer  # type: ignore[attr-defined]
