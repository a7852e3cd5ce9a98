"""Files that come with the package: scenarios, wheelsets, tracks, studies; a name finds one, a path finds another."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import InputError
from .schema import unknown
from .yaml12 import parse

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable


def names(kind: str) -> list[str]:
    """Names of the shipped files of a kind: ``scenarios``, ``wheelsets``, ``tracks``, ``studies``."""
    return sorted(entry.name.removesuffix(".yaml") for entry in _folder(kind).iterdir() if entry.name.endswith(".yaml"))


def load_yaml(kind: str, name_or_path: str | Path) -> Any:
    """Content of a shipped YAML file (by name) or of the user's (by path).

    Raises InputError if there is no such file, or if it is not YAML.
    """
    shipped = _folder(kind) / f"{name_or_path}.yaml"
    path = Path(name_or_path)
    source: Traversable | Path
    if str(name_or_path) in names(kind):
        source = shipped
    elif path.suffix in {".yaml", ".yml"} or path.exists():
        source = path
    else:
        raise InputError(unknown(singular(kind), repr(str(name_or_path)), str(name_or_path), names(kind)))
    try:
        text = source.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        known = ", ".join(names(kind))
        raise InputError(f"{source} cannot be read ({reason}): give a YAML file or one of {known}") from None
    return parse(text, str(source))


def singular(kind: str) -> str:
    """``scenario`` of ``scenarios``, ``study`` of ``studies``."""
    return kind.removesuffix("ies") + "y" if kind.endswith("ies") else kind.removesuffix("s")


def _folder(kind: str) -> Traversable:
    return files("wheelset_track_sim") / "data" / "config" / kind
