"""Tread irregularities on the grid of steps around a wheel."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

DEEPEST = 0.020
"""Greatest depth of all irregularities together, m: the contact area, and with it the work, grows with it."""


class TreadIrregularity(Protocol):
    """Deviation of a tread over a limited length around a centre."""

    @property
    def on(self) -> str:
        """``wheel_1`` or ``wheel_2``."""
        ...

    @property
    def angle(self) -> float:
        """Angle of the centre, in the order in which the tread meets the rail, rad."""
        ...

    @property
    def half_length(self) -> float:
        """Half the extent along the tread, m; the height is zero beyond."""
        ...

    def height(self, s: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height over the nominal tread, m, at ``s`` from the centre along the tread and ``y`` across it, m."""
        ...


def tread_heights(
    irregularities: Iterable[TreadIrregularity],
    wheel: str,
    rolling_circumference_steps: int,
    dx: float,
    y: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Sum of the heights on ``wheel``, (steps around the circumference, len(y)), m, negative where material is missing.

    The centre of each irregularity falls on the step nearest to its angle, so that its shape is sampled alike
    wherever it sits; it wraps around the circumference. Raises InputError for one longer than the circumference,
    for heights that are not finite, and where all together are deeper than ``DEEPEST``.
    """
    heights = np.zeros((rolling_circumference_steps, len(y)))
    for irregularity in irregularities:
        if irregularity.on != wheel:
            continue
        reach = int(np.ceil(irregularity.half_length / dx - 1e-9))
        if 2 * reach + 1 > rolling_circumference_steps:
            raise InputError(
                f"half length = {irregularity.half_length:g} m on {wheel} is longer than half the circumference: "
                f"give up to {dx * rolling_circumference_steps / 2:g} m"
            )
        centre = round(irregularity.angle / (2 * np.pi) * rolling_circumference_steps)
        offset = np.arange(-reach, reach + 1)
        rows = (centre + offset) % rolling_circumference_steps
        heights[rows] += irregularity.height(offset[:, None] * dx, y[None, :])
    if not np.isfinite(heights).all():
        raise InputError(f"tread heights of {wheel} are not finite: give finite irregularities")
    if -heights.min() > DEEPEST:
        raise InputError(
            f"tread of {wheel} is {-heights.min():.3g} m deep where irregularities overlap: "
            f"give depths that add up to {DEEPEST:g} m at most"
        )
    return heights
