"""Tread irregularities on the grid of steps around a wheel."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

DEEPEST = 0.020
"""Greatest depth of all irregularities together, m: the contact area, and with it the work, grows with it."""


class Shape(Protocol):
    """Deviation of a surface over a length around a centre."""

    @property
    def half_length(self) -> float:
        """Half the extent along the surface, m, the height being zero beyond; infinite if it is all along."""
        ...

    def height(self, s: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height over the nominal surface, m, at ``s`` from the centre along the surface and ``y`` across it, m."""
        ...


class TreadIrregularity(Shape, Protocol):
    """Deviation of a tread."""

    @property
    def on(self) -> str:
        """``wheel_1`` or ``wheel_2``."""
        ...

    @property
    def angle(self) -> float:
        """Angle of the centre, in the order in which the tread meets the rail, rad."""
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
    placed = [
        (round(each.angle / (2 * np.pi) * rolling_circumference_steps), each)
        for each in irregularities
        if each.on == wheel
    ]
    heights = summed_heights(placed, wheel, rolling_circumference_steps, dx, y)
    if -heights.min() > DEEPEST:
        raise InputError(
            f"tread of {wheel} is {-heights.min():.3g} m deep where irregularities overlap: "
            f"give depths that add up to {DEEPEST:g} m at most"
        )
    return heights


def summed_heights(
    placed: Iterable[tuple[int, Shape]], surface: str, steps: int, dx: float, y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Sum of the heights of shapes placed at steps on a ``surface`` that repeats after ``steps``, (steps, len(y)), m.

    Raises InputError for one longer than the surface, but for an infinite one, and for heights that are not finite.
    """
    heights = np.zeros((steps, len(y)))
    for centre, shape in placed:
        if np.isinf(shape.half_length):
            offset = np.arange(steps) - steps // 2
        else:
            reach = int(np.ceil(shape.half_length / dx - 1e-9))
            if 2 * reach + 1 > steps:
                raise InputError(
                    f"half length = {shape.half_length:g} m on {surface} is longer than half of it: "
                    f"give up to {dx * steps / 2:g} m"
                )
            offset = np.arange(-reach, reach + 1)
        heights[(centre + offset) % steps] += shape.height(offset[:, None] * dx, y[None, :])
    if not np.isfinite(heights).all():
        raise InputError(f"heights of {surface} are not finite: give finite irregularities")
    return heights
