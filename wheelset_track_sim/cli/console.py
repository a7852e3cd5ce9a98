"""The terminal that commands print to."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.text import Text

from ..errors import printable


class Terminal(Console):
    """Prints names from files without markup, and escapes what would do something to a terminal.

    All strings pass here, in tables too; only line breaks stay, because titles have them.
    """

    def render_str(self, text: str, **options: Any) -> Text:
        """Text of a string."""
        return super().render_str("\n".join(map(printable, text.split("\n"))), **options)


def terminal(*, stderr: bool = False) -> Console:
    """Standard output or standard error."""
    return Terminal(stderr=stderr, markup=False, emoji=False)


def print_object(values: Mapping[str, Any]) -> None:
    """Print one JSON object on standard output: laid out on a terminal, otherwise in one line."""
    console, text = terminal(), json.dumps(values)
    console.print_json(text, ensure_ascii=True) if console.is_terminal else print(text)  # noqa: T201
