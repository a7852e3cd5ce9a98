"""Wheelsets of both kinds: by geometry, and imported from another finite-element program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..inputs.schema import read
from ..inputs.shipped import load_yaml
from ..runtime.progress import Progress
from .imported import ImportedWheelset
from .reduced import ReducedWheelset
from .reduction import reduced_wheelset
from .wheelset import Wheelset, load_wheelset

AnyWheelset = Wheelset | ImportedWheelset
TABLES = ("poles", "lift", "suspension", "modal", "static", "static_lift")
"""Arrays that a file may hold as text, a row a line."""
LISTS = ("frequencies", "damping_ratios", "modal_masses", "contacts", "position")
"""The same without rows."""


def load_any_wheelset(source: str | Path | Mapping[str, Any] | AnyWheelset) -> AnyWheelset:
    """Wheelset from a shipped name, a YAML or NumPy file, or a mapping of its keys; ``imported`` tells the kinds apart.

    Raises InputError in one line for a name, key or value that cannot be used.
    """
    if isinstance(source, (Wheelset, ImportedWheelset)):
        return source
    content = source if isinstance(source, Mapping) else load_yaml("wheelsets", source)
    if isinstance(content, Mapping) and "imported" in content:
        return read(ImportedWheelset, _with_numbers(content, "wheelset"), "wheelset")
    return load_wheelset(content)


def reduce_wheelset(wheelset: AnyWheelset, progress: Progress | None = None) -> ReducedWheelset:
    """Reduced model of either kind, from the cache if it takes long to build."""
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.reduced()
    return reduced_wheelset(wheelset, progress=progress)


def _with_numbers(content: Any, where: str) -> Any:
    """``content`` with its tables, at any depth, as lists of numbers."""
    if isinstance(content, Mapping):
        return {
            key: _numbers(item, f"{where}.{key}", rows=key in TABLES)
            if key in (*TABLES, *LISTS) and isinstance(item, str)
            else _with_numbers(item, f"{where}.{key}")
            for key, item in content.items()
        }
    if isinstance(content, list):
        return [_with_numbers(item, f"{where}.{index}") for index, item in enumerate(content)]
    return content


def _numbers(text: str, where: str, *, rows: bool) -> list[Any]:
    """Rows of numbers from lines of text, or all its numbers."""
    lines = [line for line in text.splitlines() if line.strip()] if rows else [text]
    try:
        table = [[float(word) for word in line.split()] for line in lines]
    except ValueError as reason:
        raise InputError(f"{where} is not a table of numbers ({reason}): give a row a line") from None
    return table if rows else table[0]
