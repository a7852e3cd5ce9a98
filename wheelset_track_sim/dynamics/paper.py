"""From receptances to the ``paper`` dynamics: Green's functions as printed, ready to be convolved.

It is the reference beside the streaming ``causal`` dynamics. Receptances of wheelset and track up to a band limit are
padded with zeros to half the sampling frequency and transformed; the first value of the wheel's Green's functions is
set to zero (Section 2.3), that of the rail's is kept or not (``scenario.LAG_ZERO``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..runtime.arrays import Real
from ..runtime.one_core import on_one_core
from ..runtime.progress import Progress
from ..track.track import Track
from ..wheelset.reduced import ReducedWheelset
from .green_functions import folded, frequency_grid, green_function, integrated
from .moving_green_functions import BAYS, moving_green_functions
from .paper_kernels import Paper
from .running_wheelset import stress_rows

WHEEL_PERIOD = 50.0
"""Length of the wheelset's Green's functions, s (Fig. 4)."""

LONGEST_RUN = 12.0
"""Samples of the wheelset's Green's functions that are kept, s: longer runs, settling included, are refused."""

FREQUENCIES_AT_ONCE = 8192


class _Tables(NamedTuple):
    """Everything that depends on the step, in the order of ``Paper``."""

    wheel: Real
    direct: Real
    cross: Real
    stress: Real
    rail_static: Real  # (L,) m/N, a unit load on each wheel
    rail_compliance: Real  # (L,)


@dataclass(frozen=True, eq=False)
class PaperModel:
    """One wheelset and one track, whose Green's functions can be taken at any speed."""

    wheelset: ReducedWheelset
    track: Track
    max_frequency: float
    lag_zero: str
    """``printed``, ``zero`` or ``folded``."""
    nodes: tuple[int, ...]
    """Stress nodes of the wheelset that are wanted."""
    stress_rows: NDArray[np.intp]
    """(S,) where the stress components stand in the flattened (nodes, 6)."""
    progress: Progress | None = None
    bays: int = BAYS
    """Bays over which the rail's response is followed."""
    sensor_rows: ClassVar[int] = 0
    longest_run: ClassVar[float] = LONGEST_RUN

    @on_one_core
    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """Displacements of wheel and rail together, (2,) m, under ``wheel_load`` N on both wheels, mean over a bay."""
        tables = _tables(self, dx, speed)
        rail = (tables.rail_static + tables.rail_compliance).mean()
        displacement: Real = (self._wheel_static() + rail) * wheel_load
        return displacement

    @on_one_core
    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Paper:
        """Dynamics after a long run at ``speed`` m/s with the constant force ``wheel_load`` N on both wheels."""
        tables = _tables(self, dx, speed)
        static = self.wheelset.static_stress()[list(self.nodes)].sum(axis=-1).ravel()[self.stress_rows]
        return Paper(
            wheel=tables.wheel,
            direct=tables.direct,
            cross=tables.cross,
            stress=tables.stress,
            wheel_static=self._wheel_static() * wheel_load,
            rail_static=tables.rail_static * wheel_load,
            stress_static=static * wheel_load,
            load=wheel_load,
            past=np.zeros((2, tables.wheel.shape[-1])),
            coming=np.zeros((2, tables.direct.shape[-1])),
            done=np.zeros(1, np.int64),
            wheel_compliance=np.zeros(2),
            rail_compliance=tables.rail_compliance,
        )

    def at_speed(self, dynamics: Paper, step: int, dx: float, speed: float, behind: float) -> Paper:
        """Raises ValueError: a moving Green's function is that of one speed."""
        raise ValueError(f"moving Green's functions at {behind:g} m/s cannot be used at {speed:g} m/s")

    def copied(self, dynamics: Paper) -> Paper:
        """Dynamics with the same past that go on by themselves."""
        return dynamics._replace(past=dynamics.past.copy(), coming=dynamics.coming.copy(), done=dynamics.done.copy())

    def prepare(self, dx: float, speed: float) -> None:
        """Nothing: there is no other speed."""

    def _wheel_static(self) -> Real:
        return np.asarray(self.wheelset.static_receptance().sum(axis=1))


def paper_model(
    wheelset: ReducedWheelset,
    track: Track,
    nodes: Sequence[str],
    *,
    max_frequency: float,
    lag_zero: str,
    progress: Progress | None = None,
) -> PaperModel:
    """Model of the ``paper`` dynamics; raises InputError for a stress node that the wheelset does not have."""
    rows, kept = stress_rows(wheelset, nodes)
    return PaperModel(wheelset, track, max_frequency, lag_zero, tuple(rows), kept, progress)


@lru_cache(maxsize=2)
def _tables(model: PaperModel, dx: float, speed: float) -> _Tables:
    dt = dx / speed
    fold = model.lag_zero == "folded"
    wheel, stress = _wheel_tables(model, dt, fold)
    green = moving_green_functions(
        model.track,
        speed,
        dx,
        max_frequency=model.max_frequency,
        fold=fold,
        bays=model.bays,
        progress=model.progress,
    )
    direct, cross = green.discrete(round(model.track.spacing / dx), dt)
    first = np.zeros(len(direct)) if model.lag_zero == "zero" else direct[:, 0].copy()
    steps, samples = direct.shape
    both = direct + cross
    rail_static = np.zeros(steps)
    for n in range(1, samples):  # at place j by the load that hit the rail n steps ago, n places back
        rail_static += np.roll(both[:, n], n)
    return _Tables(wheel, direct, cross, stress, rail_static, first)


def _wheel_tables(model: PaperModel, dt: float, fold: bool) -> tuple[Real, Real]:
    """Time-integrated Green's functions of displacement (2, 2, N), first value zero, and of stress (S, 2, N)."""
    frequencies, samples = frequency_grid(model.max_frequency, WHEEL_PERIOD, dt)
    kept = min(round(LONGEST_RUN / dt), samples)
    wheelset = model.wheelset
    chosen = replace(
        wheelset,
        stress_outputs=wheelset.stress_outputs[list(model.nodes)],
        stress_feedthrough=wheelset.stress_feedthrough[list(model.nodes)],
        node_names=tuple(wheelset.node_names[node] for node in model.nodes),
        node_positions=wheelset.node_positions[list(model.nodes)],
    )
    rows = len(model.stress_rows)
    receptance = np.empty((4 + 2 * rows, len(frequencies)), dtype=np.complex128)
    for first in range(0, len(frequencies), FREQUENCIES_AT_ONCE):
        part = slice(first, first + FREQUENCIES_AT_ONCE)
        f = frequencies[part]
        receptance[:4, part] = chosen.receptance(f).reshape(len(f), -1).T
        stress = chosen.stress_receptance(f).reshape(len(f), -1, 2)[:, model.stress_rows]
        receptance[4:, part] = stress.reshape(len(f), -1).T
    tables = np.empty((len(receptance), kept))
    for row, response in enumerate(receptance):
        green = green_function(response, samples, dt)
        tables[row] = integrated(folded(green) if fold else green, dt)[:kept]
    wheel = tables[:4].reshape(2, 2, kept)
    wheel[..., 0] = 0.0  # Section 2.3: current wheel displacements depend on past forces only
    return wheel, tables[4:].reshape(rows, 2, kept)
