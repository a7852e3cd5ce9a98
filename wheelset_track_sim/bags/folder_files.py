"""Which files of a folder are those of its bag, and in which order.

``metadata.yaml`` lists them. Without it, all MCAP files of the folder are taken in the order of their first messages,
and a copy of a file counts once.
"""

from __future__ import annotations

import filecmp
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..inputs.text_files import is_file
from .folder_metadata import METADATA, listed_files
from .losses import Damage

SUFFIX = ".mcap"
OTHERS = (".db3", ".zstd")
"""Files of ``ros2 bag record`` that are no MCAP: SQLite, or compressed as a whole."""


@dataclass(frozen=True)
class FolderFiles:
    """Files of a bag."""

    files: tuple[Path, ...]
    """In the order in which they are read."""
    damages: tuple[Damage, ...] = ()
    """What is missing."""
    left_out: tuple[str, ...] = ()
    """Other MCAP files of the folder, each with the reason why it does not belong to the bag."""


def is_mcap(path: Path) -> bool:
    """Whether a path names an MCAP file, by its suffix."""
    return path.suffix.lower() == SUFFIX


def folder_files(folder: Path, begins: Callable[[Path], int | None]) -> FolderFiles:
    """Files of the bag in ``folder``; ``begins`` is the time of the first message of a file, None if it has none."""
    there = sorted(file for file in folder.iterdir() if is_mcap(file) and file.is_file())
    if not (folder / METADATA).is_file():
        return _by_content(there, begins, Damage(METADATA, 0, 0, "it is missing"))
    try:
        names = [*dict.fromkeys(listed_files(folder))]
    except InputError as reason:
        return _by_content(there, begins, Damage(METADATA, 0, 0, f"it cannot be read ({reason})"))
    files = tuple(folder / name for name in names if is_file(folder / name) and not name.endswith(OTHERS))
    missing = tuple(Damage(name, 0, 0, "it is missing") for name in names if folder / name not in files)
    if not files:  # of another bag, or of files that were renamed
        found = _by_content(there, begins, *missing)
        return FolderFiles(found.files, found.damages, found.left_out)
    others = tuple(f"{file.name}: metadata.yaml does not list it" for file in there if file not in files)
    return FolderFiles(files, missing, others)


def _by_content(there: list[Path], begins: Callable[[Path], int | None], *damages: Damage) -> FolderFiles:
    """Files in the order of their first messages; those without any come last."""
    first = {file: begins(file) for file in there}
    timed = sorted((time, -file.stat().st_size, file) for file, time in first.items() if time is not None)
    kept: list[Path] = []
    copies: list[str] = []
    shorter: list[Damage] = []
    for number, (time, _, file) in enumerate(timed):
        alike = [other for at, _, other in timed[:number] if at == time and other in kept]
        if not alike:
            kept.append(file)
        elif filecmp.cmp(alike[0], file, shallow=False):
            copies.append(f"{file.name}: it is a copy of {alike[0].name}")
        else:
            words = f"left out, for it begins as {alike[0].name} does: remove the one that is a copy"
            shorter.append(Damage(file.name, 0, 0, words))
    kept += [file for file in there if first[file] is None]
    return FolderFiles(tuple(kept), (*damages, *shorter), tuple(copies))
