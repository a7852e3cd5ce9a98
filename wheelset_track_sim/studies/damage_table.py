"""Tables of a size of damage: fatigue of the axle by distance, and peak force, over size, speed and load.

Each entry is a run over some distance, counted at the points of the turning axle. A passage between entries is
interpolated linearly over each axis: peaks, and the logarithm of damage over the logarithm of the load, of which damage
without defects is a power. So a fleet needs no simulation for each of its wheelsets, and a passage costs a look-up.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, WheelsetTrackError
from ..fatigue.axle import AxleFatigue, TurningWheel
from ..fatigue.curve import Curve
from ..fatigue.static_stress import check_loads, static_stress
from ..inputs.schema import confirmed_numbers
from ..runtime.arrays import Real
from ..runtime.cores import cores
from ..runtime.progress import Progress
from ..scenario import Scenario, assign, scenario_from
from ..simulation.models import load_models
from ..simulation.simulator import Simulator
from .conduct import Resources
from .workers import on_cluster, on_this_machine

SHARES = (0.05, 0.5, 0.95)
"""Quantiles of the peaks of single turns that a table has: they scatter with the place on the bay that is hit."""
NORMAL = 1.645
"""Standard deviations on either side that hold 90 % of a normal distribution."""
CHUNK = 5556
"""Steps simulated at once."""
LEAST = 1e-30
"""Damage a metre that counts as none."""


class SizeInterval(NamedTuple):
    """Size that a peak force means: estimate, and an interval of at least 90 %."""

    estimate: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class DamageTable:
    """Damage and peaks over size, speed and load, SI units."""

    key: str
    """Dotted scenario key of the size."""
    sizes: Real
    """(S,), from 0 on if the smallest is none."""
    speeds: Real
    """(V,) m/s"""
    loads: Real
    """(P,) axle loads, N."""
    nodes: tuple[str, ...]
    damage: Real
    """(S, V, P, nodes) a metre, by the elementary rule of Miner at the worst angle."""
    peaks: Real
    """(S, V, P, quantiles) of the largest force of a turn, N."""

    def damage_of(self, size: ArrayLike, speed: ArrayLike, load: ArrayLike) -> Real:
        """Damage a metre at each node, (..., nodes), at sizes, speeds and loads that broadcast.

        Raises InputError for what lies outside the table.
        """
        return np.exp(_interpolated(self, np.log(np.maximum(self.damage, LEAST)), size, speed, load, np.log))

    def peak_of(self, size: ArrayLike, speed: ArrayLike, load: ArrayLike) -> Real:
        """Quantiles of the peak force of a turn, (..., quantiles), N; raises InputError likewise."""
        return _interpolated(self, self.peaks, size, speed, load)

    def size_of(self, peak: float, speed: float, load: float, noise: float = 0.0) -> SizeInterval:
        """Size of a damage whose largest force in a turn was read as ``peak``, N.

        The interval has the scatter of peaks by the place that is hit, and the error of the reading, whose standard
        deviation is ``noise`` as a share of it. Peaks below those of the smallest size, or above those of the largest,
        mean that size. Raises InputError for a speed or load outside the table.
        """
        count = len(self.sizes)
        curves = self.peak_of(self.sizes, np.full(count, speed), np.full(count, load))
        likely, least, most = peak, peak * (1.0 - NORMAL * noise), peak * (1.0 + NORMAL * noise)
        high, middle, low = (
            float(np.interp(force, np.maximum.accumulate(curve), self.sizes))
            for force, curve in zip((most, likely, least), curves.T, strict=True)
        )
        return SizeInterval(middle, low, high)

    def save(self, path: str | Path) -> None:
        """Write a file that ``load_damage_table`` reads."""
        np.savez_compressed(path, **vars(self))

    def __post_init__(self) -> None:
        shape = (len(self.sizes), len(self.speeds), len(self.loads))
        if self.damage.shape != (*shape, len(self.nodes)) or self.peaks.shape != (*shape, len(SHARES)):
            raise InputError(f"a damage table of shape {shape} has entries of another shape: build it again")


def load_damage_table(path: str | Path) -> DamageTable:
    """Read a table that ``DamageTable.save`` wrote; raises InputError for another file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        key, nodes = str(found.pop("key")), tuple(str(name) for name in found.pop("nodes"))
        return DamageTable(key=key, nodes=nodes, **found)
    except (OSError, ValueError, KeyError, TypeError) as reason:
        raise InputError(f"{path} is no damage table ({reason}): give a file of DamageTable.save") from None


def build_damage_table(
    scenario: Scenario,
    key: str,
    sizes: Sequence[float],
    speeds: Sequence[float],
    loads: Sequence[float],
    curve: Curve,
    *,
    distance: float = 500.0,
    resources: Resources | None = None,
    progress: Progress | None = None,
) -> DamageTable:
    """Run all combinations of size, speed and load.

    Parameters
    ----------
    scenario
        What all runs have in common, with the damage.
    key
        Dotted scenario key of the size, such as ``irregularities.0.length``.
    sizes
        Rising values of the key, SI; a first size of 0 is the scenario without irregularities.
    speeds, loads
        Rising speeds, m/s, and axle loads, N.
    curve
        S-N curve.
    distance
        Of each run, m.
    resources
        Worker processes or a Dask scheduler, as of ``run_study``.
    progress
        Called with stage and fraction.

    Raises
    ------
    InputError
        For axes that do not rise, and for what a scenario refuses.
    WheelsetTrackError
        If a run fails.
    """
    for name, axis in (("sizes", sizes), ("speeds", speeds), ("loads", loads)):
        if len(axis) < 2 or not np.all(np.diff(axis) > 0):
            raise InputError(f"{name} has {len(axis)} values that do not all rise: give two or more, in their order")
    check_loads([scenario.loads])
    base = scenario.to_mapping()
    jobs = {
        number: _Row(_sized(base, key, size), tuple(speeds), tuple(loads), curve, distance)
        for number, size in enumerate(sizes)
    }
    rows: dict[int, tuple[Real, Real]] = {}
    given = resources or Resources()
    ended = (
        on_cluster(_row, jobs, given.scheduler)
        if given.scheduler is not None
        else on_this_machine(_row, jobs, min(given.workers or cores(), len(jobs)))
    )
    for number, found in ended:
        if isinstance(found, Exception):
            raise WheelsetTrackError(f"{key} = {sizes[number]:g}: {found}") from found
        rows[number] = found
        if progress:
            progress(f"damage table, {len(rows)} of {len(jobs)} sizes", len(rows) / len(jobs))
    damage, peaks = (np.stack([rows[number][part] for number in sorted(rows)]) for part in (0, 1))
    size, speed, load = (np.array(axis, dtype=np.float64) for axis in (sizes, speeds, loads))
    return DamageTable(key, size, speed, load, scenario.output.stress_nodes, damage, peaks)


class _Row(NamedTuple):
    """All runs of a size, as a worker is given them."""

    scenario: Scenario
    speeds: tuple[float, ...]
    loads: tuple[float, ...]
    curve: Curve
    distance: float


def _sized(base: Mapping[str, Any], key: str, size: float) -> Scenario:
    data = copy.deepcopy(dict(base))
    if size == 0.0:
        data["irregularities"] = []
    else:
        assign(data, key, size)
    with confirmed_numbers():
        return scenario_from(data)


def _row(row: _Row) -> tuple[Real, Real]:
    """Damage a metre (V, P, nodes) and quantiles of peaks (V, P, quantiles) of a size."""
    models = load_models(row.scenario)
    found = [
        _entry(Simulator(replace(row.scenario, speed=speed, axle_load=load), models=models), row)
        for speed in row.speeds
        for load in row.loads
    ]
    damage, peaks = (np.array([each[part] for each in found]) for part in (0, 1))
    shape = len(row.speeds), len(row.loads), -1
    return damage.reshape(shape), peaks.reshape(shape)


def _entry(simulator: Simulator, row: _Row) -> tuple[Real, Real]:
    scenario, turn = simulator.scenario, simulator.steps_per_revolution
    static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    fatigue = AxleFatigue(static, TurningWheel.of(scenario), row.curve)
    forces = []
    steps = math.ceil(row.distance / scenario.step_length / turn) * turn
    while simulator.next_step < steps:
        block = simulator.advance(min(CHUNK, steps - simulator.next_step))
        fatigue.push(block)
        forces.append(block.forces.max(axis=1))
    by_turn = np.concatenate(forces).reshape(-1, turn).max(axis=1)
    damage = [node.damage_in(1.0)[0] for node in fatigue.nodes]
    return np.array(damage), np.quantile(by_turn, SHARES)


def _interpolated(
    table: DamageTable,
    values: Real,
    size: ArrayLike,
    speed: ArrayLike,
    load: ArrayLike,
    of_load: Callable[[Any], Any] = np.asarray,
) -> Real:
    """Values (S, V, P, n) between the entries, (..., n): linear along each axis, and over a function of the load."""
    places, weights = [], []
    for name, axis, wanted in zip(
        (table.key, "speed", "axle_load"), (table.sizes, table.speeds, table.loads), (size, speed, load), strict=True
    ):
        at = np.asarray(wanted, dtype=np.float64)
        if not ((at >= axis[0]) & (at <= axis[-1])).all():
            raise InputError(
                f"{name} from {at.min():g} to {at.max():g} is outside the damage table, which has {axis[0]:g} to "
                f"{axis[-1]:g}: build a table with that range"
            )
        below = np.clip(np.searchsorted(axis, at, side="right") - 1, 0, len(axis) - 2)
        places.append(below)
        scale = of_load if axis is table.loads else np.asarray
        here, low, high = (scale(each) for each in (at, axis[below], axis[below + 1]))
        weights.append((here - low) / (high - low))
    total: Any = 0.0
    for corner in np.ndindex(2, 2, 2):
        entry = tuple(place + step for place, step in zip(places, corner, strict=True))
        weight = math.prod((w if step else 1.0 - w) for w, step in zip(weights, corner, strict=True))
        total = total + np.asarray(weight)[..., np.newaxis] * values[entry]
    return np.asarray(total)
