"""Models on disk under a digest of everything that changes them.

The folder is the user's cache folder (``XDG_CACHE_HOME`` or ``~/.cache``); ``WHEELSET_TRACK_SIM_CACHE`` names
another. A file that cannot be read is reported and built again; a file is never half-written under its final name.
"""

from __future__ import annotations

import hashlib
import json
import logging
import math
import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from inspect import isfunction
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
import platformdirs

from .one_core import one_core
from .sources import program

if TYPE_CHECKING:
    from typing_extensions import Self, TypeVarTuple, Unpack

    from .progress import Progress

    Inputs = TypeVarTuple("Inputs")

CONTENT = "digest of the content"
"""Name in the file of a model; a file whose arrays have another digest is damaged, whatever they look like."""
FORMAT = 1
"""Version of the form in which inputs are digested: bags hold such digests, too."""

log = logging.getLogger(__name__)


class Storable(Protocol):
    """A model that turns into named arrays and back."""

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Arrays that make up the model, by name."""
        ...

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Model from its arrays; raises KeyError or ValueError if they are not those of such a model."""
        ...


Model = TypeVar("Model", bound=Storable)


def folder() -> Path:
    """Folder of cached models."""
    named = os.environ.get("WHEELSET_TRACK_SIM_CACHE")
    return Path(named) if named else platformdirs.user_cache_path("wheelset_track_sim") / "models"


def digest(inputs: Any) -> str:
    """Digest of dataclasses, mappings, sequences, arrays, numbers and text; floats count by their exact value."""
    return hashlib.blake2b(json.dumps([FORMAT, _plain(inputs)], sort_keys=True).encode(), digest_size=16).hexdigest()


def cached(
    kind: str,
    model: type[Model],
    build: Callable[[Unpack[Inputs], Progress | None], Model],
    *inputs: Unpack[Inputs],
    progress: Progress | None = None,
    most: float = math.inf,
) -> Model:
    """Model ``build(*inputs, progress)``, stored as ``kind-key.npz``; built if the file is missing or damaged.

    The key is a digest of the inputs and of the module of ``build`` with all that it imports (``sources.program``).
    So ``build`` has to be a function of a module, which makes its model of the inputs alone: TypeError for a method, a
    partial and a function that uses variables of another one. Of this kind at most ``most`` bytes are kept, those that
    were used last.
    """
    if not isfunction(build) or build.__closure__:
        raise TypeError(f"{build} of the cached {kind} uses more than its arguments: make it a function of a module")
    path = folder() / f"{kind}-{digest([program(build.__module__), build.__qualname__, inputs])}.npz"
    if path.exists():
        try:
            with np.load(path, allow_pickle=False) as stored:
                found = model.from_arrays(_sound(dict(stored)))
            with suppress(OSError):  # a folder that may be read only
                os.utime(path)
            return found
        except Exception as damage:  # noqa: BLE001  any damage whatever ends in a rebuild
            log.warning("cached model %s cannot be read (%s): built again", path, damage)
    with one_core():
        built: Model = build(*inputs, progress)
    store(path, built)
    if most < math.inf:
        _keep_latest(kind, most)
    return built


def store(path: Path, model: Storable) -> None:
    """Write a model under a temporary name, then rename: readers see all of it or nothing.

    A folder that cannot be written is reported and left: the model is in memory and the run goes on.
    """
    temporary: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
            temporary = Path(file.name)
            arrays = {name: np.asarray(array) for name, array in model.to_arrays().items()}
            np.savez(file, allow_pickle=False, **arrays, **{CONTENT: np.array(digest(arrays))})
        temporary.replace(path)
    except OSError as reason:
        log.warning("model is not cached: %s cannot be written (%s)", path, reason)
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def _sound(stored: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    content = str(stored.pop(CONTENT, ""))
    if digest(stored) != content:
        raise ValueError("its content is not what was written")
    return stored


def _keep_latest(kind: str, most: float) -> None:
    """Remove the models of a kind that were used longest ago, as far as all together have more than ``most`` bytes."""
    with suppress(OSError):  # another process removes, too
        found = sorted(
            ((path.stat(), path) for path in folder().glob(f"{kind}-*.npz")), key=lambda one: -one[0].st_mtime_ns
        )
        sizes = accumulate(stat.st_size for stat, _ in found)
        for size, (_, path) in zip(sizes, found, strict=True):
            if size > most:
                path.unlink(missing_ok=True)


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return [type(value).__name__, {field.name: _plain(getattr(value, field.name)) for field in fields(value)}]
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        content = hashlib.blake2b(np.ascontiguousarray(value).tobytes(), digest_size=16)
        return [value.dtype.str, value.shape, content.hexdigest()]
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value.hex()
    return value
