"""Files of a page: style and words that pages share, and files that are written whole or not at all."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from ..errors import InputError

PAPER = (
    "M. Maglio, A. Pieringer, J. C. O. Nielsen, T. Vernersson, “Wheel–rail impact loads and axle bending stress "
    "simulated for generic distributions and shapes of discrete wheel tread damage”."
)


def asset(name: str) -> str:
    """Text of a file beside this one."""
    return (files(__package__) / name).read_text(encoding="utf-8")


STYLE = asset("page.css")
"""Style sheet of a page, for light and dark, wide and narrow, and paper."""


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file, and the folders on the way to it; what stood there before stays until all of it is written.

    Returns ``path``; raises InputError if it cannot be written. What is no file, as ``/dev/stdout``, is written to.
    """
    temporary = path.parent / f"{path.name}.tmp"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return path
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as reason:
        raise InputError(f"{path} cannot be written ({reason.strerror}): give another path with --out") from None
    return path
