"""The dynamics as the simulator knows them: one interface, three implementations: ``causal``, ``line``, ``paper``."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real


class DynamicsModel(Protocol):
    """Wheelset and track that can be started at a speed; what it starts is stepped by ``interface_kernels``."""

    @property
    def stress_rows(self) -> NDArray[np.intp]:
        """(S,) where the stress components that are stepped stand in the flattened (nodes, 6)."""
        ...

    @property
    def sensor_rows(self) -> int:
        """Rows of sensors that are stepped."""
        ...

    @property
    def longest_run(self) -> float:
        """Bound on a run, settling included, s."""
        ...

    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        ...

    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Any:
        """Dynamics at ``speed`` m/s at ``step``, at rest or in steady running under ``wheel_load`` N on both wheels."""
        ...

    def at_speed(self, dynamics: Any, step: int, dx: float, speed: float, behind: float) -> Any:
        """Dynamics with the state of ``dynamics`` at another ``speed`` m/s; ``behind`` is that of the last interval.

        Where they differ, what is returned serves for ``step`` alone.
        """
        ...

    def copied(self, dynamics: Any) -> Any:
        """Dynamics in the state of ``dynamics`` that go on by themselves; coefficients are shared."""
        ...

    def prepare(self, dx: float, speed: float) -> None:
        """Work out ahead of time what ``at_speed`` takes long for; from any thread, and without effect on results."""
        ...
