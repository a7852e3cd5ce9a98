"""The terminal that commands print to."""

from __future__ import annotations

from rich.console import Console


def terminal(*, stderr: bool = False) -> Console:
    """Standard output or standard error, on which names from files stand as they are: nothing in them is markup."""
    return Console(stderr=stderr, markup=False, emoji=False)
