"""The terminal that commands print to."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rich.console import Console


def terminal(*, stderr: bool = False) -> Console:
    """Standard output or standard error, which prints names from files as they are, without markup."""
    return Console(stderr=stderr, markup=False, emoji=False)


def print_object(values: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output: laid out on a terminal, otherwise in one line."""
    console, text = terminal(), json.dumps(values)
    console.print_json(text) if console.is_terminal else print(text)  # noqa: T201
