"""The potential contact area: the elements that a contact may reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from ..errors import InputError
from ..irregularities import RailHeights
from ..irregularities.surface import WHEELS
from ..runtime.arrays import Real
from .geometry import ContactGeometry


def potential_contact_area(
    geometry: ContactGeometry,
    dx: float,
    dy: float,
    smooth_reach: float,
    treads: Sequence[Real],
    rails: Sequence[RailHeights],
) -> tuple[Real, Real]:
    """Elements x and y of the potential contact area, m.

    Where all heights within the area lie between ``low`` and ``high``, a force needs at most the approach of a smooth
    contact that lies at ``low``; so all elements in contact have a nominal separation of up to ``smooth_reach`` and
    high - low. What long waves raise and lower as a whole does not count.
    """
    on_treads = [(heights.max(axis=1), heights.min(axis=1)) for heights in treads]
    on_rails = [(heights.max(axis=1)[row], heights.min(axis=1)[row]) for row, heights in rails]
    reach, needed = 0.0, smooth_reach
    while needed > reach:
        reach = needed
        x, y = contact_grid(geometry, dx, dy, reach)
        needed = smooth_reach + sum(
            max(_difference_within(high, low, len(x)) for high, low in pair) for pair in (on_treads, on_rails)
        )
    return x, y


def _difference_within(high: Real, low: Real, nx: int) -> float:
    """Largest difference, m, of the highest and the lowest within nx steps of a surface, both (steps,), m."""
    nx = min(nx, len(high))
    return float((maximum_filter1d(high, nx, mode="wrap") - minimum_filter1d(low, nx, mode="wrap")).max())


def contact_grid(geometry: ContactGeometry, dx: float, dy: float, reach: float) -> tuple[Real, Real]:
    """Positions x and y of the elements whose nominal separation is below ``reach``, m, and of one row more around.

    They count from where wheel and rail touch. With half-spaces the contact lies where the undeformed bodies would
    overlap, so this holds every contact of an approach up to ``reach``, under both wheels. Odd in number, with an
    element in the middle; not beside both rail heads. Raises InputError if the points of a profile end within.
    """
    half_y, radius = 0, geometry.wheel_radius
    for name, pair in zip(WHEELS, geometry.pairs, strict=True):
        if not reach <= pair.open_gap:
            raise InputError(
                f"the points of {name} or its rail end where the surfaces are {pair.open_gap:.3g} m apart, within the "
                f"potential contact area of {reach:.3g} m: give points further out"
            )
        for side, end in zip((-1, 1), pair.span, strict=True):
            y = np.arange(int(side * (end - pair.touch) / dy * (1 + 1e-12)) + 1) * dy
            within = np.flatnonzero(pair.gap(pair.touch + side * y) < reach)
            half_y = max(half_y, min(int(within[-1]) + 1, len(y) - 1))
            radius = max(radius, geometry.wheel_radius + pair.wheel_height(pair.touch + side * y[within]).max())
    half_x = int(np.sqrt(reach * (2 * radius - reach)) / dx) + 1
    return evenly_spaced(half_x, dx), evenly_spaced(half_y, dy)


def evenly_spaced(half: int, step: float) -> Real:
    """Positions from -half to half steps, (2 half + 1,)."""
    return np.arange(-half, half + 1, dtype=np.float64) * step
