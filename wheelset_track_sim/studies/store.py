"""Results on disk, one file a finished run: a study that was stopped continues where it was."""

from __future__ import annotations

import json
import logging
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import WheelsetTrackError
from .evaluate import Result

log = logging.getLogger(__name__)

VALUES, LABEL = "values", "label"
"""Entries of a file beside the arrays."""


class Store:
    """Folder of finished runs, each under the digest of all that changes it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def load(self, key: str) -> Result | None:
        """Result stored under ``key``; None if there is none. A damaged file is reported and counts as none."""
        path = self._path(key)
        if not path.exists():
            return None
        try:
            with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
                entries = dict(file)  # reads all of it, so that the checksums are checked
            values = json.loads(str(entries.pop(VALUES)))
            entries.pop(LABEL)
            return Result({str(name): float(value) for name, value in values.items()}, entries)
        except Exception as damage:  # noqa: BLE001  any damage whatever ends in another run
            log.warning("result %s cannot be read (%s): the run is done again", path, damage)
            return None

    def save(self, key: str, result: Result, label: str) -> None:
        """Write a result under a temporary name, then rename: a reader sees all of it or nothing, at any moment.

        ``label`` is for people who open the file. Raises WheelsetTrackError if it cannot be written.
        """
        temporary: Path | None = None
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self.folder, suffix=".tmp", delete=False) as file:
                temporary = Path(file.name)
                entries: Any = {VALUES: np.array(json.dumps(result.values)), LABEL: np.array(label), **result.arrays}
                np.savez_compressed(file, **entries)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(self._path(key))
        except OSError as reason:
            if temporary is not None:
                temporary.unlink(missing_ok=True)
            raise WheelsetTrackError(
                f"result {self._path(key)} cannot be written ({reason.strerror}): finished results are kept, free "
                "some disk space"
            ) from None

    def tidy(self) -> None:
        """Remove what a killed program left half-written."""
        for left in self.folder.glob("*.tmp"):
            left.unlink(missing_ok=True)

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"
