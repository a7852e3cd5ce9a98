"""Amplitude of the bending stress that points of a turning axle go through, from the stress at nodes that do not turn.

The stress at the top of the axle is ``b(t)`` from bending, with compression at the bottom of the same size: the first
harmonic around the axle. A point of the surface that passes the top at an angle ``phi`` of the wheel sees
``b(t) cos(theta(t) + phi)``, with ``theta`` the angle that the wheel has turned. Its amplitude over a turn is half the
range of that; the amplitude of the node is that of the point that has it worst.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import Real
from .rotating_bending_kernels import widen

POINTS = 36
"""Points over half of the circumference: the other half sees the same with the other sign. It costs 0.1 % at most."""


class Amplitudes(NamedTuple):
    """Amplitudes by node, Pa."""

    begun: tuple[float, ...]
    """Of the turn that has begun, as far as it goes."""
    turn: tuple[float, ...]
    """Of the last complete turn; NaN before."""


class RotatingBending:
    """Amplitudes by turns in a stream of gap-free samples at full rate: the same ones however the stream is cut.

    Turn ``k`` has the steps from ``k`` to before ``k + 1`` times the steps in a turn.
    """

    def __init__(self, steps_per_revolution: int, nodes: int) -> None:
        """For wheels of ``steps_per_revolution`` steps, and a number of stress nodes."""
        self._turn = steps_per_revolution
        turned = 2 * np.pi * np.arange(steps_per_revolution) / steps_per_revolution
        self._cosines = np.cos(turned[:, np.newaxis] + np.pi * np.arange(POINTS) / POINTS)
        self._low, self._high = np.full((nodes, POINTS), np.inf), np.full((nodes, POINTS), -np.inf)
        self._last = (math.nan,) * nodes
        self._whole = False

    def push(self, first_step: int, bending: Real) -> list[tuple[float, ...]]:
        """Amplitudes, Pa, of the turns that samples ``bending`` (n, nodes), Pa, from ``first_step`` on complete."""
        found = []
        row = 0
        while row < len(bending):
            step = (first_step + row) % self._turn
            if step == 0:
                self._low[:], self._high[:] = np.inf, -np.inf
                self._whole = True
            part = bending[row : row + self._turn - step]
            widen(self._low, self._high, part, self._cosines[step : step + len(part)])
            row += len(part)
            if step + len(part) == self._turn and self._whole:
                self._last = self._amplitudes()
                found.append(self._last)
        return found

    @property
    def amplitudes(self) -> Amplitudes:
        """Of the turn that has begun, and of the last complete one."""
        return Amplitudes(self._amplitudes(), self._last)

    def _amplitudes(self) -> tuple[float, ...]:
        ranges = np.maximum(self._high - self._low, 0.0)  # before the first sample it is less than nothing
        return tuple(float(worst) / 2 for worst in ranges.max(axis=1))
