"""Force tables of all tread positions that need one of their own."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import ContactError
from ..runtime.arrays import Real
from ..runtime.cache import cached
from ..runtime.cores import cores
from ..runtime.progress import Progress
from .path_kernels import follow_path

if TYPE_CHECKING:
    from typing_extensions import Self

STORED = 256e6
"""Bytes of force tables kept on disk, some hundred defects: a node whose damage changes all day does not fill it."""


@dataclass(frozen=True, eq=False)
class ForceTables:
    """Exact force-approach curves of several geometries, one after the other."""

    first: NDArray[np.int64]
    """Where each curve starts in ``points``, and where the last ends, (tables + 1,)."""
    points: Real
    """Kinks, (points, 2): approach, m, and force, N."""

    def to_arrays(self) -> dict[str, Real | NDArray[np.int64]]:
        """Arrays by name."""
        return {"first": self.first, "points": self.points}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Tables from stored arrays; ValueError if they do not fit together."""
        first, points = arrays["first"], arrays["points"]
        if points.shape != (first[-1], 2) or first[0] != 0 or not np.isfinite(points).all():
            raise ValueError("these are no force tables")
        return cls(first, points)


def force_path(
    separation: Real,
    mirrored: bool,
    influence: Real,
    element_area: float,
    largest_force: float,
    largest_pressure: float = np.inf,
) -> Real:
    """Kinks of the force-approach curve, (points, 2): approach, m, and force, N, rising from first touch.

    The last point is at ``largest_force``, where an element has ``largest_pressure``, Pa, or where the contact reaches
    the border of the area (nx, ny) of ``separation``, m. Arguments as in ``solve_active_set``.
    """
    ny = separation.shape[1]
    first = ny // 2 if mirrored else 0
    flat = separation[:, first:].ravel()
    order = np.argsort(flat, kind="stable")
    order = order[np.isfinite(flat[order])]
    at_i, at_j = np.divmod(order, ny - first)
    return follow_path(
        at_i,
        at_j + first,
        flat[order],
        separation.shape,
        mirrored,
        influence,
        element_area,
        largest_force,
        largest_pressure,
    )


class _Recent:
    """The latest curves of this process: where one of several defects changes, those of the others serve again."""

    def __init__(self, most: int) -> None:
        self._most, self._lock = most, threading.Lock()
        self._curves: dict[bytes, Real] = {}

    def curve(self, separation: Real, influence: Real, element_area: float, *largest: float) -> Real:
        contents = hashlib.blake2b(repr((separation.shape, element_area, *largest)).encode(), digest_size=16)
        for array in (separation, influence):
            contents.update(np.ascontiguousarray(array).tobytes())
        key = contents.digest()
        with self._lock:
            found = self._curves.pop(key, None)
        if found is None:
            mirrored = bool((separation == separation[:, ::-1]).all())
            found = force_path(separation, mirrored, influence, element_area, *largest)
        with self._lock:
            self._curves[key] = found  # at the end: the latest
            while len(self._curves) > self._most:
                self._curves.pop(next(iter(self._curves)))
        return found


_RECENT = _Recent(1024)


def force_tables(
    gaps: list[Real],
    influence: Real,
    element_area: float,
    largest_force: float,
    largest_pressure: float = np.inf,
    progress: Progress | None = None,
) -> ForceTables:
    """Curves of separations (nx, ny), m, from the model cache if they are there.

    They end at ``largest_force``, N, or where the first element has ``largest_pressure``, Pa.

    Raises ContactError for a curve that is not finite.
    """
    inputs = gaps, influence, element_area, largest_force, largest_pressure
    tables = cached("force-tables", ForceTables, _tables, *inputs, progress=progress, most=STORED)
    if len(tables.first) != len(gaps) + 1:
        raise ContactError(f"{len(tables.first) - 1} force tables are stored for {len(gaps)} geometries")
    return tables


def _tables(
    gaps: list[Real],
    influence: Real,
    element_area: float,
    largest_force: float,
    largest_pressure: float,
    progress: Progress | None,
) -> ForceTables:
    curves: list[Real] = []
    shared = influence, element_area, largest_force, largest_pressure
    # Curves do not depend on each other, and kernels hold no lock: a changed defect is there in a fraction of the time.
    with ThreadPoolExecutor(cores(), "force-tables") as pool:
        found = [pool.submit(_RECENT.curve, gap, *shared) for gap in gaps]
        try:
            for number, curve in enumerate(found):
                curves.append(_rising(curve.result(), f"{number} of {len(gaps)}"))
                if progress is not None:
                    progress("contact tables", (number + 1) / len(gaps))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    first = np.cumsum([0, *(len(curve) for curve in curves)], dtype=np.int64)
    return ForceTables(first, np.concatenate(curves))


def _rising(curve: Real, name: str) -> Real:
    """The curve; ContactError if it is none."""
    if not np.isfinite(curve).all() or (np.diff(curve, axis=0) <= 0.0).any():
        raise ContactError(f"force table {name} is not finite and rising")
    return curve
