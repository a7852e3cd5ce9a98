"""Which files of a folder are those of its bag, and in which order.

``metadata.yaml`` lists them. Without it, all files of the folder with the suffix of one are taken in the order of their
first messages, and a copy of a file counts once.
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

SUFFIX, PACKED = ".mcap", ".zstd"
SUFFIXES = (SUFFIX, ".db3", SUFFIX + PACKED, ".db3" + PACKED)
"""Of the files of bags: MCAP and SQLite, as they are and compressed as a whole."""


@dataclass(frozen=True)
class FolderFiles:
    """Files of a bag."""

    files: tuple[Path, ...]
    """In the order in which they are read."""
    damages: tuple[Damage, ...] = ()
    """What is missing."""
    left_out: tuple[str, ...] = ()
    """Other such files of the folder, each with the reason why it does not belong to the bag."""


def is_mcap(path: Path) -> bool:
    """Whether a path names an MCAP file, by its suffix."""
    return path.suffix.lower() == SUFFIX


def suffix_of(path: Path) -> str:
    """Suffix by which a path names a file of a bag, as it is written; empty if it names none."""
    return next((path.name[-len(suffix) :] for suffix in SUFFIXES if path.name.lower().endswith(suffix)), "")


def folder_files(folder: Path, begins: Callable[[Path], int | None]) -> FolderFiles:
    """Files of the bag in ``folder``; ``begins`` is the time of the first message of a file, None if it has none."""
    there = sorted(file for file in folder.iterdir() if suffix_of(file) and file.is_file())
    names = {file.name for file in there}
    there = [file for file in there if file.name + PACKED not in names]  # ros2 bag leaves what it has unpacked
    if not (folder / METADATA).is_file():
        return _by_content(there, begins, Damage(METADATA, 0, 0, "it is missing"))
    try:
        listed = [*dict.fromkeys(listed_files(folder))]
    except InputError as reason:
        return _by_content(there, begins, Damage(METADATA, 0, 0, f"it cannot be read ({reason})"))
    found = {name: _packed_or_not(folder / name) for name in listed}
    files = tuple(file for file in found.values() if file is not None)
    missing = tuple(Damage(name, 0, 0, "it is missing") for name, file in found.items() if file is None)
    if not files:  # of another bag, or of files that were renamed
        return _by_content(there, begins, *missing)
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


def _packed_or_not(path: Path) -> Path | None:
    """A file that is listed, or what ``ros2 bag`` has unpacked it to; None if neither is there."""
    unpacked = path.with_name(path.name.removesuffix(PACKED))
    return next((file for file in (path, unpacked) if is_file(file)), None)
