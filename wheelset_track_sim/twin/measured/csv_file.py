"""CSV files of signals, written."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

from ...errors import InputError
from ...runtime.arrays import Real
from .measurement import Axis


def write_csv(path: Path, axis: Axis, at: Real, signals: Mapping[str, Real], unit: str) -> None:
    """Write signals in ``unit`` (such as ``Pa``) as a file that ``read_measurement`` reads, every bit kept.

    Raises InputError if it exists or cannot be written; nothing is left behind then.
    """
    try:
        file = path.open("x", encoding="utf-8", newline="")
    except FileExistsError:
        raise InputError(f"{path} exists already: give another path, or remove it first") from None
    except OSError as reason:
        raise _unwritable(path, reason) from None
    try:
        with file:
            writer = csv.writer(file)
            writer.writerow([f"{axis} [{'s' if axis == 'time' else 'm'}]", *(f"{name} [{unit}]" for name in signals)])
            writer.writerows([repr(float(cell)) for cell in row] for row in zip(at, *signals.values(), strict=True))
    except BaseException as reason:
        path.unlink(missing_ok=True)
        if isinstance(reason, OSError):
            raise _unwritable(path, reason) from None
        raise


def _unwritable(path: Path, reason: OSError) -> InputError:
    return InputError(f"{path} cannot be written ({reason.strerror}): give another path")
