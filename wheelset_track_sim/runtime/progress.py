"""How long work reports its progress."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, float], None]
"""Called with a stage and the fraction of it that is done, 0 to 1. An exception that it raises ends the work."""


def unreported(stage: str, fraction: float) -> None:
    """Progress that is not shown."""
