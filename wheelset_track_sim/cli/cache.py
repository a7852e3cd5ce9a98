"""``cache``: list and remove models and compiled functions that are kept on disk."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from ..errors import InputError, WheelsetTrackError
from ..inputs.schema import unknown
from ..runtime.cache import folder
from ..runtime.jit import caches
from .console import print_object, terminal

ALL = "all"
KERNELS = "kernels"
HOLDS = {
    "wheelset": "reduced wheelsets",
    "track": "rings of sleeper bays",
    "moving-track": "reduced tracks",
    "moving-green": "Green's functions",
    "force-tables": "contact force tables",
    KERNELS: "compiled functions",
}
"""Kinds of entries, with what they hold."""


class Entry(NamedTuple):
    """A file of a model, or a folder of compiled functions."""

    kind: str
    path: Path
    size: int
    """Bytes."""
    used: float
    """Time of its last use, s since 1970."""


def cache(clear: str | None, *, json: bool) -> int:
    """List the cache, or remove a kind of entries or ``ALL`` of them; returns the exit status.

    Raises InputError for a kind that is not known, WheelsetTrackError for an entry that cannot be removed.
    """
    found = [*_models(), *_kernels()]
    kinds = sorted({entry.kind for entry in found}.union(HOLDS), key=lambda kind: [*HOLDS, kind].index(kind))
    if clear not in (None, ALL, *kinds):
        raise InputError(unknown("kind of cache", f"--clear {clear}", str(clear), [ALL, *kinds]))
    if clear is not None:
        kinds = [kind for kind in kinds if clear in (ALL, kind)]
        found = [entry for entry in found if entry.kind in kinds]
        for entry in found:
            _remove(entry)
    listed = [_sums(kind, [entry for entry in found if entry.kind == kind]) for kind in kinds]
    total = sum(entry.size for entry in found)
    folders = {"models": str(folder()), KERNELS: str(caches())}
    if json:
        name = "kinds" if clear is None else "removed"
        print_object({"folders": folders, name: listed, "size_bytes": total})
        return 0
    console = terminal()
    for name, path in folders.items():
        console.print(f"{name}: {path}", highlight=False, soft_wrap=True)
    table = Table("kind", "holds", title="cache" if clear is None else "removed")
    for heading in ("entries", "size", "last use"):
        table.add_column(heading, justify="right")
    for row in listed:
        used = row["last_use"]
        when = f"{datetime.fromisoformat(used).astimezone():%Y-%m-%d %H:%M}" if used else ""
        table.add_row(row["kind"], HOLDS.get(row["kind"], ""), str(row["entries"]), _megabytes(row["size_bytes"]), when)
    table.add_section()
    table.add_row("together", "", str(len(found)), _megabytes(total), "")
    console.print(table)
    return 0


def _models() -> Iterator[Entry]:
    for path in sorted(folder().glob("*.npz")):
        named = re.fullmatch(r"(.+)-[0-9a-f]{32}\.npz", path.name)
        if named:
            state = path.stat()
            yield Entry(named[1], path, state.st_size, state.st_mtime)


def _kernels() -> Iterator[Entry]:
    for path in sorted(path for path in caches().glob("*") if path.is_dir()):
        size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
        yield Entry(KERNELS, path, size, path.stat().st_mtime)


def _remove(entry: Entry) -> None:
    try:
        shutil.rmtree(entry.path) if entry.path.is_dir() else entry.path.unlink(missing_ok=True)
    except OSError as reason:
        raise WheelsetTrackError(
            f"{entry.path} cannot be removed ({reason.strerror}): make its folder writable"
        ) from None


def _sums(kind: str, entries: list[Entry]) -> dict[str, Any]:
    """What the entries of a kind come to; the last use is null if there are none."""
    used = max((entry.used for entry in entries), default=None)
    return {
        "kind": kind,
        "entries": len(entries),
        "size_bytes": sum(entry.size for entry in entries),
        "last_use": None if used is None else datetime.fromtimestamp(used, timezone.utc).isoformat(timespec="seconds"),
    }


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"
