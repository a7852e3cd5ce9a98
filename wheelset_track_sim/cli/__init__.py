"""The command line: a module for each command, and one for its arguments in ``parsers``."""

import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status. An interrupt while modules load is an orderly end of a node."""
    try:
        from .command_line import main as run
    except KeyboardInterrupt:
        given = sys.argv[1:] if arguments is None else [*arguments]
        if given[:1] in (["node"], ["replay"], ["echo"]) and "--simulate-again" not in given:
            return 0
        print("wheelset-track-sim: interrupted", file=sys.stderr)  # noqa: T201
        return 1
    return run(arguments)


__all__ = ["main"]
