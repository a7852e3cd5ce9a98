"""The files of a bag: which there are, in their order, and which should be there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ..errors import InputError, NoBagError
from ..inputs.yaml12 import parse
from .losses import Damage
from .rosbag2_metadata import METADATA


def files_of(path: Path) -> tuple[Path, ...]:
    """Files of a bag, which is one of them or their folder; raises NoBagError if there are none."""
    if not path.exists():
        raise NoBagError(f"{path} does not exist: give a bag folder or an .mcap file")
    if path.is_file():
        return (path,)
    files = sorted(path.glob("*.mcap"), key=lambda file: (_number(file.name), file.name))
    if not files:
        inside = min((file.parent for file in path.glob("*/*.mcap")), default=None)  # of snapshots, of recordings
        such = f", such as {inside}" if inside else ""
        raise NoBagError(f"{path} holds no .mcap file: give a bag folder or an .mcap file{such}")
    return tuple(files)


def beside(path: Path, ending: str) -> Path:
    """A path beside a bag: with ``.html``, ``run.html`` for ``run.mcap`` and ``run.1.html`` for a folder ``run.1``.

    For ``.``, too, whose name is that of the folder in which one is.
    """
    path = path if path.name not in ("", "..") else path.resolve()
    return path.with_name(f"{path.name.removesuffix('.mcap')}{ending}")


def missing_files(path: Path) -> list[Damage]:
    """What ``metadata.yaml`` of a folder names and is not there; its own loss, too. None for a single file."""
    if not path.is_dir():
        return []
    text = path / METADATA
    if not text.exists():
        return [Damage(text.name, 0, 0, "it is missing")]
    try:
        names = [str(name) for name in _parsed(text.read_text("utf-8"))["relative_file_paths"]]
    except (OSError, InputError, ValueError, LookupError, TypeError):
        return [Damage(text.name, 0, 0, "it cannot be read")]
    return [Damage(name, 0, 0, "it is missing") for name in names if not (path / name).exists()]


def _parsed(text: str) -> Any:
    """What ``metadata.yaml`` says; only its list of files if that stands as recorders write it: YAML takes its time."""
    files = re.search(r"(?m)^ *relative_file_paths:(?:\n *- .*)+", text)
    return parse(files[0].strip(), METADATA) if files else parse(text, METADATA)["rosbag2_bagfile_information"]


def _number(name: str) -> int:
    """Number at the end of a file's name."""
    found = re.search(r"(\d+)\.mcap$", name)
    return int(found[1]) if found else 0
