"""Force tables of all tread positions that need one of their own."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import cache
from ..errors import ContactError
from . import active_set_kernels, path_kernels
from .path_kernels import follow_path

if TYPE_CHECKING:
    from typing_extensions import Self

STORED = 256e6
"""Bytes of force tables kept on disk, some hundred defects: a node whose damage changes all day does not fill it."""

Progress = Callable[[float], None]
"""Told the share of the work that is done, 0 to 1."""


ROUGH = 0.9
"""Share of the circumference beyond which a tread is rough all around: then no two positions have a table in common."""


@dataclass(frozen=True, eq=False)
class ForceTables:
    """Exact force-approach curves of several geometries, one after the other."""

    first: NDArray[np.int64]
    """Where each curve starts in ``points``, and where the last ends, (tables + 1,)."""
    points: NDArray[np.float64]
    """Kinks, (points, 2): approach, m, and force, N."""

    def to_arrays(self) -> dict[str, NDArray[np.float64] | NDArray[np.int64]]:
        """Arrays by name."""
        return {"first": self.first, "points": self.points}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """Tables from stored arrays; ValueError if they do not fit together."""
        first, points = arrays["first"], arrays["points"]
        if points.shape != (first[-1], 2) or first[0] != 0 or not np.isfinite(points).all():
            raise ValueError("these are no force tables")
        return cls(first, points)


@dataclass(frozen=True, eq=False)
class Windows:
    """Distinct separations of wheel and rail within the potential contact area, and where on the treads each stands."""

    number: NDArray[np.int32]
    """Window of each tread position, (2, n_c); -1 one that is rough all around."""
    gaps: list[NDArray[np.float64]]
    """Separations, tread heights included, each (nx, ny), m."""
    smooth: int
    """The first so many windows are those of smooth treads: 1, or 2 where the wheels' profiles differ."""


def windows(tread: NDArray[np.float64], separation: NDArray[np.float64], smooth_reach: float) -> Windows:
    """Distinct windows of ``tread`` (2, n_c, ny) as seen by an area of nominal ``separation`` (2, nx, ny).

    ``smooth_reach``, m, is the approach that a smooth tread does not exceed within the tables. Where all elements with
    a separation, nominal or true, below it are smooth, the contact is that of a smooth tread. Mirror images along x
    share a window: the force is the same. So do the two wheels if their nominal surfaces are alike, or mirror images.
    """
    nx = separation.shape[1]
    n_c = tread.shape[1]
    found: dict[tuple[int, bytes], int] = {}
    gaps = [separation[0]]
    number = np.zeros(tread.shape[:2], np.int32)
    offset = np.arange(nx) - nx // 2
    alike = bool((separation[1] == separation[0]).all())
    turned = not alike and bool((separation[1] == separation[0][:, ::-1]).all())
    if not (alike or turned):
        gaps.append(separation[1])
    smooth = len(gaps)
    for wheel in range(len(tread)):
        base = wheel % smooth
        across = slice(None, None, -1) if wheel == 1 and turned else slice(None)
        nominal = gaps[base]
        number[wheel] = base
        rough = np.flatnonzero(tread[wheel].any(axis=1))
        if len(rough) > ROUGH * n_c:
            number[wheel] = -1
            continue
        for position in np.unique((rough[:, None] - offset) % n_c):
            window = tread[wheel, (position + offset) % n_c, across]
            if not window[np.minimum(nominal, nominal - window) < smooth_reach].any():
                continue
            key = base, min(window.tobytes(), window[::-1].tobytes())
            if key not in found:
                found[key] = len(gaps)
                gaps.append(nominal - window)
            number[wheel, position] = found[key]
    return Windows(number, gaps, smooth)


def force_path(
    separation: NDArray[np.float64],
    mirrored: bool,
    influence: NDArray[np.float64],
    element_area: float,
    largest_force: float,
) -> NDArray[np.float64]:
    """Kinks of the force-approach curve, (points, 2): approach, m, and force, N, rising from first touch.

    The last point is at ``largest_force``, or where the contact reaches the border of the area (nx, ny) of
    ``separation``, m. Arguments as in ``solve_active_set``.
    """
    ny = separation.shape[1]
    first = ny // 2 if mirrored else 0
    flat = separation[:, first:].ravel()
    order = np.argsort(flat, kind="stable")
    order = order[np.isfinite(flat[order])]
    at_i, at_j = np.divmod(order, ny - first)
    return follow_path(
        at_i, at_j + first, flat[order], separation.shape, mirrored, influence, element_area, largest_force
    )


class _Recent:
    """The latest curves of this process: where one of several defects changes, those of the others serve again."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._curves: dict[bytes, NDArray[np.float64]] = {}

    def curve(
        self, separation: NDArray[np.float64], influence: NDArray[np.float64], element_area: float, largest_force: float
    ) -> NDArray[np.float64]:
        contents = hashlib.blake2b(repr((separation.shape, element_area, largest_force)).encode(), digest_size=16)
        for array in (separation, influence):
            contents.update(np.ascontiguousarray(array).tobytes())
        key = contents.digest()
        found = self._curves.pop(key, None)
        if found is None:
            mirrored = bool((separation == separation[:, ::-1]).all())
            found = force_path(separation, mirrored, influence, element_area, largest_force)
        self._curves[key] = found  # at the end: the latest
        while len(self._curves) > self._most:
            self._curves.pop(next(iter(self._curves)), None)
        return found


_RECENT = _Recent(1024)


def force_tables(
    gaps: list[NDArray[np.float64]],
    influence: NDArray[np.float64],
    element_area: float,
    largest_force: float,
    progress: Progress | None = None,
) -> ForceTables:
    """Curves up to ``largest_force``, N, of separations (nx, ny), m, from the model cache if they are there.

    Raises ContactError for a curve that is not finite.
    """

    def build() -> ForceTables:
        curves = []
        for number, gap in enumerate(gaps):
            curves.append(_RECENT.curve(gap, influence, element_area, largest_force))
            if not np.isfinite(curves[-1]).all() or (np.diff(curves[-1], axis=0) <= 0.0).any():
                raise ContactError(f"force table {number} of {len(gaps)} is not finite and rising")
            if progress is not None:
                progress((number + 1) / len(gaps))
        first = np.cumsum([0, *(len(curve) for curve in curves)], dtype=np.int64)
        return ForceTables(first, np.concatenate(curves))

    contents = hashlib.blake2b(digest_size=16)
    for array in (influence, *gaps):
        contents.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    key = cache.digest([contents.hexdigest(), element_area, largest_force], path_kernels, active_set_kernels)
    tables = cache.cached("force-tables", ForceTables, key, build, most=STORED)
    if len(tables.first) != len(gaps) + 1:
        raise ContactError(f"{len(tables.first) - 1} force tables are stored for {len(gaps)} geometries")
    return tables
