"""Arrays in Zarr, format 3, written chunk by chunk: each file is there whole or not at all.

A chunk has the samples of one passage of a train. The format is a folder of files of JSON and of compressed values, so
the bytes depend on the values alone, and what a killed program leaves behind is what it had finished.
<https://zarr-specs.readthedocs.io/en/latest/v3/core/v3.0.html>
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import zstandard

from ..errors import InputError, WheelsetTrackError
from ..runtime.arrays import Single

META = "zarr.json"
LEVEL = 3
"""Of compression."""


@dataclass(frozen=True)
class ArrayPlan:
    """An array of float32: shape, chunk along its first dimension, names of dimensions, attributes."""

    shape: tuple[int, ...]
    chunk: int
    dimensions: tuple[str, ...]
    attributes: Mapping[str, Any]

    @property
    def metadata(self) -> dict[str, Any]:
        """As the format has it."""
        return {
            "zarr_format": 3,
            "node_type": "array",
            "shape": list(self.shape),
            "data_type": "float32",
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [self.chunk, *self.shape[1:]]}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": "NaN",
            "codecs": [
                {"name": "bytes", "configuration": {"endian": "little"}},
                {"name": "zstd", "configuration": {"level": LEVEL, "checksum": False}},
            ],
            "attributes": dict(self.attributes),
            "dimension_names": list(self.dimensions),
        }


class ChunkStore:
    """A group of arrays in a folder."""

    def __init__(self, folder: Path, plans: Mapping[str, ArrayPlan], attributes: Mapping[str, Any]) -> None:
        self.folder, self.plans = folder, plans
        arrays = {name: plan.metadata for name, plan in plans.items()}
        self._group = {
            "zarr_format": 3,
            "node_type": "group",
            "attributes": dict(attributes),
            "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": arrays},
        }

    def begin(self) -> None:
        """Make the folder, or go on in it; raises InputError if it is that of something else, or not writable."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            here = self.folder / META
            if not here.exists() and any(self.folder.iterdir()):
                raise InputError(f"{self.folder} is a folder with other files: give another --out")
            if here.exists() and json.loads(here.read_text(encoding="utf-8")) != self._group:
                raise InputError(
                    f"{self.folder} holds another data set, or one of another version: give another --out, or remove it"
                )
            for left in self.folder.rglob("*.tmp"):
                left.unlink()
            self.write_text(META, dumped(self._group))
            for name, plan in self.plans.items():
                self.write_text(f"{name}/{META}", dumped(plan.metadata))
        except (OSError, ValueError) as reason:
            if isinstance(reason, InputError):
                raise
            raise InputError(f"{self.folder} cannot be used ({reason}): give another folder with --out") from None

    def has(self, chunk: int) -> bool:
        """Whether a chunk of all arrays is there."""
        return all(self._path(name, chunk).exists() for name in self.plans)

    def save(self, chunk: int, arrays: Mapping[str, Single]) -> None:
        """Write a chunk of all arrays; raises WheelsetTrackError if that cannot be done."""
        for name, plan in self.plans.items():
            values = np.full((plan.chunk, *plan.shape[1:]), np.nan, "<f4")
            values[: len(arrays[name])] = arrays[name]
            packed = zstandard.ZstdCompressor(level=LEVEL).compress(values.tobytes())
            self._write(self._path(name, chunk), packed)

    def load(self, name: str, chunk: int) -> Single:
        """One chunk of an array, the samples that there are."""
        plan = self.plans[name]
        packed = self._path(name, chunk).read_bytes()
        values = np.frombuffer(zstandard.ZstdDecompressor().decompress(packed), "<f4")
        whole = values.reshape(plan.chunk, *plan.shape[1:])
        return np.asarray(whole[: plan.shape[0] - chunk * plan.chunk])

    def write_text(self, name: str, text: str) -> None:
        """Write a file of text beside the arrays."""
        self._write(self.folder / name, text.encode())

    def _path(self, name: str, chunk: int) -> Path:
        return self.folder / name / "c" / "/".join([str(chunk), *("0" for _ in self.plans[name].shape[1:])])

    def _write(self, path: Path, content: bytes) -> None:
        temporary: Path | None = None
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
                temporary = Path(file.name)
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            temporary.chmod(0o644)
            temporary.replace(path)
        except OSError as reason:
            if temporary is not None:
                temporary.unlink(missing_ok=True)
            raise WheelsetTrackError(
                f"{path} cannot be written ({reason.strerror}): finished samples are kept, free some disk space"
            ) from None


def dumped(content: Any) -> str:
    """JSON of a file."""
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"
