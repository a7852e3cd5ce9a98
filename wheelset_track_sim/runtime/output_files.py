"""Where outputs go: file names by one rule, in folders that exist, over no file that is there already."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

from ..errors import InputError

LONGEST = 100
"""Bytes of a name: beginnings and suffixes are added to it."""


def file_name(name: str) -> str:
    """Name of a file for what has a ``name``: letters, digits, ``_``, ``-``, ``+`` and ``.``, none of these first.

    Anything else, such as a slash, becomes an underscore: a name leads to no other folder. Never empty. What is too
    long ends in a digest of the whole, so that names that begin alike stay apart.
    """
    plain = re.sub(r"[^\w.+-]+", "_", name).strip("._-+") or "unnamed"
    if len(plain.encode()) <= LONGEST:
        return plain
    digest = hashlib.blake2b(plain.encode(), digest_size=4).hexdigest()
    return f"{plain.encode()[: LONGEST - 9].decode(errors='ignore')}_{digest}"


def require_folder(path: Path) -> None:
    """Raise InputError if the folder in which ``path`` is to be written does not exist."""
    if not path.absolute().parent.is_dir():
        raise InputError(f"{path} cannot be written: its folder does not exist, create {path.absolute().parent} first")


def require_new(paths: Iterable[Path], *, overwrite: bool) -> None:
    """Raise InputError for the first path that is a file already, unless it may be overwritten."""
    for path in paths:
        if path.is_file() and not overwrite:
            raise InputError(f"{path} exists already: give another path, or --overwrite to replace it")
