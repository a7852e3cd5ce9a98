"""Which places on treads and rails have a force table, and which of them share one."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..irregularities.surface import distinct_rows
from ..runtime.arrays import Real

ROUGH = 0.9
"""Share of a surface beyond which it is rough all along: then no two positions have a table in common."""
MOST_IN_A_STRETCH = 400
"""Tables of a stretch of nearly smooth surface: where more would be needed, a solution in each step is cheaper."""
NEARLY_SMOOTH = 0.1e-3
"""Differences of height within the contact area of such a stretch, m, which the nested solver takes in its stride."""
MOST_IN_ANY = 3000
"""Tables of any stretch, a minute or two of work; beyond, each step is solved."""
OFTEN = 8
"""Times that a window stands in a stretch to have a table where not all have: waves of a whole number of steps do."""


class Windows(NamedTuple):
    """Distinct separations of wheel and rail within the potential contact area, and where each occurs."""

    gaps: list[Real]
    """Separations, heights included, each (nx, ny), m."""
    tread: NDArray[np.int32]
    """Window of each tread position on a smooth rail, (2, n_c); -1 where contacts are solved."""
    rail: NDArray[np.int32]
    """Window of each rail position under a smooth tread, (2, n_r); 0 where it is smooth, likewise."""
    smooth: int
    """The first so many windows are those of smooth surfaces: 1, or 2 where the wheels' profiles differ."""


def windows(
    tread: Real,
    rail_row: NDArray[np.int32],
    rail: Real,
    separation: Real,
    smooth_reach: float,
) -> Windows:
    """Distinct windows of treads and rails as seen by an area of nominal ``separation`` (2, nx, ny).

    Heights are those of ``ContactLaw``. ``smooth_reach``, m, is the approach that a smooth tread does not exceed within
    the tables. Where all elements with a separation, nominal or true, below it are smooth, the contact is that of
    smooth surfaces. Mirror images along x share a window: the force is the same. So do the two wheels if their nominal
    surfaces are alike, or mirror images, and a tread and a rail.
    """
    n_c, ny = tread.shape[1:]
    rough = [_rough_all_along(each) for each in rail_row]
    looked_at = np.unique(rail_row[np.flatnonzero(np.logical_not(rough))])
    heights = np.concatenate([np.zeros((1, ny)), *tread, rail[looked_at]])
    rows, number = distinct_rows(np.concatenate([heights, heights[:, ::-1]]))
    plain, turned = number.reshape(2, -1)
    alike = bool((separation[1] == separation[0]).all())
    mirrored = not alike and bool((separation[1] == separation[0][:, ::-1]).all())
    search = _Search(rows, [separation[0]] if alike or mirrored else [*separation], smooth_reach)
    on_treads, on_rails = np.empty((2, n_c), np.int32), np.empty(rail_row.shape, np.int32)
    for wheel in range(2):
        row = turned if wheel == 1 and mirrored else plain
        base = wheel % search.smooth
        on_treads[wheel] = search.numbers(row[1 + wheel * n_c :][:n_c], base)
        if rough[wheel]:
            on_rails[wheel] = -1
            continue
        found = search.numbers(row[1 + 2 * n_c :][np.searchsorted(looked_at, rail_row[wheel])], base)
        on_rails[wheel] = np.where(found == base, 0, found)
    return Windows(search.gaps, on_treads, on_rails, search.smooth)


class _Search:
    """Windows found so far."""

    def __init__(self, rows: Real, nominal: list[Real], smooth_reach: float) -> None:
        self.gaps, self.smooth, self._rows, self._reach = [*nominal], len(nominal), rows, smooth_reach
        self._found: dict[tuple[int, bytes], int] = {}
        self._top, self._bottom = rows.max(axis=1), rows.min(axis=1)

    def numbers(self, row: NDArray[np.int32], base: int) -> NDArray[np.int32]:
        """Window of each position of a surface whose rows are given, (steps,); ``base`` is that of a smooth one."""
        nx, steps = len(self.gaps[base]), len(row)
        number = np.full(steps, base, np.int32)
        if _rough_all_along(row):
            number[:] = -1
            return number
        rough = np.flatnonzero(row)
        near = np.zeros(steps, np.bool_)
        for offset in range(-(nx // 2), nx // 2 + 1):
            near[(rough + offset) % steps] = True
        places = np.flatnonzero(near)
        for stretch in np.split(places, 1 + np.flatnonzero(np.diff(places) > 1)) if len(places) else []:
            number[stretch] = self._stretch(row, stretch, base)
        return number

    def _stretch(self, row: NDArray[np.int32], positions: NDArray[np.intp], base: int) -> NDArray[np.int32]:
        """Window of each of the consecutive ``positions``; -1 for rare ones where all would be too many."""
        nominal = self.gaps[base]
        ids = row[(positions[:, None] + np.arange(len(nominal)) - len(nominal) // 2) % len(row)]
        keys = [min(one.tobytes(), turned.tobytes()) for one, turned in zip(ids, ids[:, ::-1], strict=True)]
        times = Counter(keys)
        difference = (self._top[ids].max(axis=1) - self._bottom[ids].min(axis=1)).max()
        most, least = MOST_IN_A_STRETCH if difference < NEARLY_SMOOTH else MOST_IN_ANY, 1
        if len(times) > most:
            least = OFTEN if sum(count >= OFTEN for count in times.values()) <= most else len(keys) + 1
        number = np.full(len(positions), -1, np.int32)
        for place, key in enumerate(keys):
            if times[key] >= least:
                number[place] = self._number(ids[place], key, base)
        return number

    def _number(self, ids: NDArray[np.int32], key: bytes, base: int) -> int:
        """Of the window of some rows, or the window of a smooth surface if these rows cannot carry a load."""
        nominal = self.gaps[base]
        if (base, key) not in self._found:
            window = self._rows[ids]
            bears = window[np.minimum(nominal, nominal - window) < self._reach].any()
            self._found[base, key] = len(self.gaps) if bears else base
            if bears:
                self.gaps.append(nominal - window)
        return self._found[base, key]


def _rough_all_along(row: NDArray[np.int32]) -> bool:
    """Whether a surface, whose rows are given, is solved everywhere; row 0 is smooth."""
    return bool(np.count_nonzero(row) > ROUGH * len(row)) and len(np.unique(row)) > MOST_IN_A_STRETCH
