"""The command line: a module for each command, and one for its arguments in ``parsers``."""

import sys
from collections.abc import Sequence

from .loading import loading


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    with loading(given):
        try:
            from .command_line import main as run
        except KeyboardInterrupt:
            print("wheelset-track-sim: interrupted", file=sys.stderr)  # noqa: T201
            return 1
        return run(given)


__all__ = ["main"]
