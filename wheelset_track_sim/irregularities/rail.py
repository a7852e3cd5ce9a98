"""Rail irregularities on the grid of steps along the track."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .tread import Shape, summed_heights


class RailIrregularity(Shape, Protocol):
    """Deviation of a rail."""

    @property
    def on(self) -> str:
        """``rail_1`` or ``rail_2``: the one under that wheel."""
        ...

    @property
    def position(self) -> float:
        """Position of the centre along the track, m."""
        ...


def rail_heights(
    irregularities: Iterable[RailIrregularity], rail: str, steps: int, dx: float, y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Sum of the heights on ``rail``, which repeats after ``steps``, (steps, len(y)), m, from position 0 on.

    The centre of each irregularity falls on the nearest step. Raises InputError as ``tread_heights`` does.
    """
    placed = [(round(each.position / dx), each) for each in irregularities if each.on == rail]
    return summed_heights(placed, rail, steps, dx, y)
