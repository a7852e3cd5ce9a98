"""Text files as they come: with or without byte order mark, in UTF-8, UTF-16 or Windows-1252."""

from __future__ import annotations

import codecs
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib.resources import files
from pathlib import Path
from typing import IO, TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

LARGEST = 1_000_000_000
"""Bytes of a file at most."""
SHIPPED = Path(str(files("wheelset_track_sim"))) / "data"
"""Folder of the files that come with the package."""
_closed: ContextVar[bool] = ContextVar("closed", default=False)


@contextmanager
def without_files() -> Iterator[None]:
    """Let input within open none but shipped files: whoever sent it must not choose what is read here."""
    token = _closed.set(True)
    try:
        yield
    finally:
        _closed.reset(token)


def _require_open(source: Traversable | Path) -> None:
    path = Path(str(source))
    if _closed.get() and not (path.is_relative_to(SHIPPED) and ".." not in path.parts):
        raise InputError(f"{source} is a file, and a scenario in a bag opens none: give its content instead")


def exists(path: Path) -> bool:
    """Whether there is anything at a path; False for a name that no file can have."""
    try:
        return path.exists()
    except OSError:  # too long
        return False


def is_file(path: Path) -> bool:
    """Whether there is a regular file at a path; False for a name that no file can have."""
    try:
        return path.is_file()
    except OSError:
        return False


@contextmanager
def opened(source: Traversable | Path, largest: int = LARGEST) -> Iterator[IO[bytes]]:
    """Regular file to read; what goes wrong with it meanwhile becomes an InputError that names it."""
    _require_open(source)
    if isinstance(source, Path) and not is_file(source) and exists(source):
        kind = "a folder" if source.is_dir() else "a device or a pipe"
        raise InputError(f"{source} is {kind}: give a regular file")
    if re.search("[\0\ud800-\udc7f\udd00-\udfff]", str(source)):
        raise InputError(f"{source} cannot be the name of a file: give another file")
    try:
        with source.open("rb") as file:
            size = file.seek(0, io.SEEK_END)
            file.seek(0)
            if size > largest:
                raise InputError(f"{source} has {size} bytes: give at most {largest}")
            yield file
    except OSError as reason:
        raise InputError(f"{source} cannot be read ({reason.strerror or reason}): give another file") from None


@contextmanager
def opened_text(source: Traversable | Path, largest: int = LARGEST) -> Iterator[IO[str]]:
    """Text file to read.

    Bytes that are neither UTF-8 nor, by their mark or their zeros, UTF-16, are taken as Windows-1252, which holds
    Latin-1. A file with control characters is no text: InputError.
    """
    try:
        with opened(source, largest) as file, io.TextIOWrapper(file, _encoding(file, source)) as text:
            yield text
    except UnicodeError:
        raise _no_text(source) from None


def read_text(source: Traversable | Path, largest: int = LARGEST) -> str:
    """Content of a text file; raises InputError if it cannot be read."""
    with opened_text(source, largest) as text:
        return text.read()


def _encoding(file: IO[bytes], source: Traversable | Path) -> str:
    start = file.read(4096)
    file.seek(0)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    zeros = [start[side::2].count(0) for side in (0, 1)]
    if max(zeros) > len(start) / 4 and not min(zeros):
        return "utf-16-be" if zeros[0] else "utf-16-le"
    if any(byte < 32 and byte not in b"\t\n\v\f\r" for byte in start):
        raise _no_text(source)
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        while part := file.read(1 << 20):
            decoder.decode(part)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return "cp1252"
    finally:
        file.seek(0)
    return "utf-8-sig"


def _no_text(source: Traversable | Path) -> InputError:
    return InputError(f"{source} is not text: give a text file")
