"""Files that come with the package: scenarios, wheelsets, tracks, studies; a name finds one, a path finds another."""

from __future__ import annotations

import re
from importlib.resources import files
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .amounts import whole_number
from .numpy_files import UNREADABLE
from .schema import unknown
from .text_files import exists, opened, read_text
from .yaml12 import MOST_VALUES, parse

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

MAX_DEPTH = 8
"""Models that stand on one another by ``base``."""
MOST_BYTES = 100_000_000
"""Bytes that an ``.npz`` file is unpacked to."""


def names(kind: str, suffix: str = ".yaml") -> list[str]:
    """Names of the shipped files of a kind: ``scenarios``, ``wheelsets``, ``tracks``, ``studies``."""
    return sorted(entry.name.removesuffix(suffix) for entry in _folder(kind).iterdir() if entry.name.endswith(suffix))


def kinds() -> list[str]:
    """Kinds of shipped files that have names: ``scenarios``, ``studies`` and so on."""
    return sorted(entry.name for entry in _folder("").iterdir() if entry.is_dir() and names(entry.name))


def kind_of(text: str) -> str:
    """Kind that a text names in its singular or plural; raises InputError."""
    known = kinds()
    for kind in known:
        if text in (kind, singular(kind)):
            return kind
    raise InputError(unknown("kind of shipped file", repr(text), text, [singular(kind) for kind in known]))


def text(kind: str, name: str) -> str:
    """Text of a shipped file; raises InputError if there is none of that name."""
    if name not in names(kind):
        raise InputError(unknown(f"shipped {singular(kind)}", repr(name), name, names(kind)))
    return read_text(_folder(kind) / f"{name}.yaml")


def description(kind: str, name: str) -> str:
    """What a shipped file is, in one line: its title, or the first sentence of the comment that it begins with."""
    content = text(kind, name)
    comment = " ".join(line.lstrip("# ") for line in takewhile(lambda line: line[:1] == "#", content.splitlines()))
    found = re.match(r"(.+?)\.(\s|$)", comment)
    titled = re.search(r"^title: *(.+)$", content, re.MULTILINE)
    return titled[1].strip() if titled else found[1] if found else comment


def file(kind: str, name: str) -> Traversable:
    """Shipped file of a kind by its whole name."""
    return _folder(kind) / name


def load_yaml(kind: str, name_or_path: str | Path) -> Any:
    """Content of a shipped YAML file (by name) or of the user's (by path), which may be an ``.npz`` of the same keys.

    Raises InputError if there is no such file, or if it is not what its name says.
    """
    shipped = _folder(kind) / f"{name_or_path}.yaml"
    path = Path(name_or_path)
    source: Traversable | Path
    if str(name_or_path) in names(kind):
        source = shipped
    elif path.suffix.lower() == ".npz":
        return _arrays(path)
    elif path.suffix.lower() in {".yaml", ".yml"} or exists(path):
        source = path
    else:
        raise InputError(unknown(singular(kind), repr(str(name_or_path)), str(name_or_path), names(kind)))
    try:
        text = read_text(source)
    except InputError as refusal:
        raise InputError(f"{refusal}, or one of {', '.join(names(kind))}") from None
    return parse(text, str(source))


def _arrays(path: Path) -> dict[str, Any]:
    """Mapping from the arrays of a file: dots in their names lead into mappings, whole numbers into lists.

    Arrays of numbers become text, a row a line: YAML holds that as quickly as it is read here.
    """
    try:
        with opened(path) as file, ZipFile(file) as packed:
            unpacked = sum(part.file_size for part in packed.infolist())
            if unpacked > MOST_BYTES:
                raise InputError(f"{path} unpacks to {unpacked} bytes: give at most {MOST_BYTES}")  # noqa: TRY301
            with np.load(file, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in sorted(stored.files)}
    except InputError:
        raise
    except UNREADABLE as reason:
        raise InputError(f"{path} cannot be read ({reason}): give a file of numpy.savez") from None
    content: dict[str, Any] = {}
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray):
            raise InputError(f"{path}: {name} is no array: give a file of numpy.savez")
        if array.size > MOST_VALUES:
            raise InputError(f"{path}: {name} has {array.size} numbers: give at most {MOST_VALUES}")
        *parts, last = name.split(".", MAX_DEPTH)
        place = content
        for part in parts:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise InputError(f"{path}: {name} is within {part}, which is an array: give either")
        table = array.ndim > 0 and array.dtype.kind in "fiu"
        place[last] = table_text(array) if table else array.tolist()
    plain = _with_lists(content)
    return plain if isinstance(plain, dict) else {}


def table_text(array: NDArray[Any]) -> str:
    """Numbers (n,) or (n, m) as text, a row a line; read again they are the same, bit by bit."""
    rows = np.atleast_2d(array.T).T if array.ndim == 1 else array
    return "".join(" ".join(map(repr, row)) + "\n" for row in np.asarray(rows, dtype=np.float64).tolist())


def _with_lists(content: Any) -> Any:
    if not isinstance(content, dict):
        return content
    plain = {key: _with_lists(item) for key, item in content.items()}
    if plain and all(whole_number(key) is not None for key in plain):
        return [plain[key] for key in sorted(plain, key=int)]
    return plain


def located(kind: str, name_or_path: str) -> Traversable | Path:
    """A shipped file of a kind by its whole name, or the user's by its path; it may not be there."""
    path = Path(name_or_path)
    found = _folder(kind) / name_or_path if path.name == name_or_path else None
    return found if found is not None and found.is_file() and not exists(path) else path


def singular(kind: str) -> str:
    """``scenario`` of ``scenarios``, ``study`` of ``studies``."""
    if kind == "criteria":
        return "criterion"
    return kind.removesuffix("ies") + "y" if kind.endswith("ies") else kind.removesuffix("s")


def _folder(kind: str) -> Traversable:
    return files("wheelset_track_sim") / "data" / "config" / kind
