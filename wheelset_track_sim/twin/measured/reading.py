"""Measurements from files of any kind that is known: CSV, and bags with the messages of this package."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...bags import Bag
from ...errors import InputError
from ...wheelset.reduced import COMPONENTS
from .comparison import WHEELS
from .csv_file import read_csv
from .measurement import Measurement


def read_measurement(path: str | Path) -> Measurement:
    """Measurement from a CSV file or a bag; raises InputError or RecordingError for what cannot be used.

    In a bag forces are ``ContactForces`` and stresses ``AxleStress``, at the full rate of who measured them.
    """
    path = Path(path)
    if path.is_dir() or path.suffix == ".mcap":
        return _of_bag(path)
    if not path.exists():
        raise InputError(f"{path} does not exist: give a CSV file or a bag")
    return read_csv(path)


def _of_bag(path: Path) -> Measurement:
    blocks = [*Bag(path).blocks()]
    time = np.concatenate([block.time + np.arange(len(block)) * block.step_period for block in blocks])
    forces, stresses = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("forces", "stresses"))
    signals = dict(zip(WHEELS, forces.T, strict=True))
    principal = np.concatenate([block.max_principal for block in blocks])
    for number, node in enumerate(blocks[0].nodes):
        signals[node] = principal[:, number]
        signals |= {
            f"{node}_{component}": stresses[:, number, index]
            for index, component in enumerate(COMPONENTS)
            if stresses[:, number, index].any()
        }
    return Measurement(path, "time", time, signals)
