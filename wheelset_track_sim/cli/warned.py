"""Warnings about input, as lines on standard error."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..errors import InputWarning


@contextmanager
def printed_warnings(program: str) -> Iterator[list[str]]:
    """Print each InputWarning within on standard error, once; the list holds the texts printed so far."""
    printed: list[str] = []
    with warnings.catch_warnings():
        show = warnings.showwarning

        def print_or_show(message: Warning | str, category: type[Warning], *place: Any, **options: Any) -> None:
            if not issubclass(category, InputWarning):
                show(message, category, *place, **options)
            elif str(message) not in printed:
                printed.append(str(message))
                print(f"{program}: warning: {message}", file=sys.stderr)  # noqa: T201

        warnings.simplefilter("always", InputWarning)
        warnings.showwarning = print_or_show
        yield printed
