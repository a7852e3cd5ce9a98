"""The ``paper`` dynamics with moving Green's functions known at few places only: experiments, not options.

The tables of Eq. (3) are cut to ``SAMPLES``, 0.29 s, by which the rail has come to rest, and a run settles for 0.6 s.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Literal
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from wheelset_track_sim.dynamics.green_functions import green_function, integrated
from wheelset_track_sim.dynamics.moving_green_functions import moving_green_functions
from wheelset_track_sim.dynamics.paper import PaperModel
from wheelset_track_sim.dynamics.paper_kernels import Paper
from wheelset_track_sim.scenario import Scenario
from wheelset_track_sim.simulation import simulator
from wheelset_track_sim.simulation.models import Models
from wheelset_track_sim.track.bloch import bloch_track
from wheelset_track_sim.track.track import HALVES, Track

Real = NDArray[np.float64]
How = Literal["nearest", "linear"]

SAMPLES = 8000
SETTLING = 0.6
"""s"""
NODES = 8
"""Rail nodes a bay (Section 4)."""
BAYS = 16


@dataclass(frozen=True)
class Sampling:
    """How the tables are made."""

    starts: int = 600
    """Places in a bay at which a load can start."""
    load: How = "nearest"
    responses: int = 0
    """Places in a bay at which responses are known, the steps between interpolated; 0 is every step."""
    response: How = "linear"
    latest: bool = False
    """Whether the function of the present place serves for all earlier forces, too."""
    cross: float = 1.0
    """Factor on the functions of the opposite rail."""
    every: int = 1
    """Steps between the samples in time that are known, the others interpolated."""
    first: bool = True
    """Whether the first value is kept."""
    mirrored: bool = False
    """Whether the start places run against the direction of travel."""

    def applied(self, scenario: Scenario, models: Models) -> Models:
        """Models whose rails respond by these tables; for ``runs.passage``."""
        model = models.dynamics
        assert isinstance(model, PaperModel)
        return replace(models, dynamics=sampled_model(self, model, scenario.step_length, scenario.speed))

    def tables(self, model: PaperModel, dx: float, speed: float) -> tuple[Real, Real]:
        """Direct and cross tables (L, SAMPLES)."""
        if self.responses:
            direct, cross = self._by_nodes(model.track, model.max_frequency, dx, speed)
        else:
            whole = moving_green_functions(model.track, speed, dx, max_frequency=model.max_frequency)
            steps = round(model.track.spacing / dx)
            direct, cross = (self._by_starts(table[:, :SAMPLES]) for table in whole.discrete(steps, dx / speed))
        return self._altered(direct), self._altered(cross)

    def _by_starts(self, table: Real) -> Real:
        """Whole moving functions of few starts, each run from its own start."""
        steps = len(table)
        place = np.arange(steps) * self.starts / steps
        known = table[np.arange(self.starts) * steps // self.starts]
        if self.load == "nearest":
            return np.asarray(known[np.floor(place + 0.5).astype(int) % self.starts])
        low = np.floor(place + 1e-9).astype(int)
        part = (place - low)[:, np.newaxis]
        return np.asarray((1 - part) * known[low % self.starts] + part * known[(low + 1) % self.starts])

    def _by_nodes(self, track: Track, band: float, dx: float, speed: float) -> tuple[Real, Real]:
        """Load on the start places, response at the load's true place from those of ``responses`` a bay."""
        steps, dt = round(track.spacing / dx), dx / speed
        green = ordinary(track, band, dt)
        rows = np.empty((2, steps, SAMPLES))
        for step in range(steps):
            place = step * self.starts / steps
            if self.load == "nearest":
                shares = {int(np.floor(place + 0.5)): 1.0}
            else:
                low = int(place + 1e-9)
                shares = {low: 1 - place + low, low + 1: place - low}
            rows[:, step] = 0.0
            for start, share in shares.items():
                if share > 1e-9:
                    own = green[start % self.starts * (NODES // self.starts)]
                    back = track.spacing * (start // self.starts)
                    rows[:, step] += share * self._along(own, (step * dx - back) / track.spacing, dx / track.spacing)
        rows = np.stack([integrated(row, dt) for row in rows])
        return rows[0], rows[1]

    def _along(self, green: NDArray[np.float32], begin: float, step: float) -> Real:
        """Responses (2, SAMPLES) at ``begin + n step`` bays, sample n each, from ordinary functions at nodes."""
        known = green[:, :: NODES // self.responses]
        n = np.arange(SAMPLES)
        place = (begin + n * step + 1.0) * self.responses
        inside = place < known.shape[1] - 1
        n, place = n[inside], place[inside]
        found = np.zeros((2, SAMPLES))
        if self.response == "nearest":
            found[:, n] = known[:, np.floor(place + 0.5).astype(int), n]
        else:
            low = np.floor(place + 1e-9).astype(int)
            found[:, n] = (1 - place + low) * known[:, low, n] + (place - low) * known[:, low + 1, n]
        return found

    def _altered(self, table: Real) -> Real:
        steps, samples = table.shape
        n = np.arange(samples)
        if self.mirrored:
            table = table[-np.arange(steps) % steps]
        if self.latest:
            table = table[(np.arange(steps)[:, np.newaxis] + n) % steps, n]
        if self.every > 1:
            low = n // self.every
            part = (n - low * self.every) / self.every
            high = np.minimum((low + 1) * self.every, samples - 1)
            table = (1 - part) * table[:, low * self.every] + part * table[:, high]
        table = np.array(table)
        if not self.first:
            table[:, 0] = 0.0
        return table


@lru_cache(maxsize=1)
def ordinary(track: Track, band: float, dt: float) -> NDArray[np.float32]:
    """Ordinary Green's functions of Eq. (2), (NODES, 2, nodes, SAMPLES), per s: load and responses at rail nodes.

    Nodes count from one bay behind the load's; 2 is the loaded rail and the opposite one.
    """
    samples = 2 * SAMPLES
    frequencies = np.arange(int(band * samples * dt) + 1) / (samples * dt)
    places = np.arange(-NODES, BAYS * NODES + 1) * track.spacing / NODES
    halves = [bloch_track(track, half, frequencies) for half in HALVES]
    found = np.empty((NODES, 2, len(places), SAMPLES), np.float32)
    for start in range(NODES):
        even, odd = (half.receptance(start * track.spacing / NODES, places) for half in halves)
        for rail, receptance in enumerate(((even + odd) / 2, (even - odd) / 2)):
            found[start, rail] = green_function(receptance, samples, dt)[:, :SAMPLES]
    return found


@dataclass(frozen=True, eq=False)
class SampledModel:
    """Dynamics of the wheelset by ``model`` and of the rails by given tables (L, M), m/N."""

    model: PaperModel
    direct: Real
    cross: Real
    changes_speed = False

    @property
    def stress_rows(self) -> NDArray[np.intp]:
        """As of the model."""
        return self.model.stress_rows

    @property
    def longest_run(self) -> float:
        """As of the model, s."""
        return self.model.longest_run

    def copied(self, dynamics: Any) -> Any:
        """As of the model."""
        return self.model.copied(dynamics)

    @cached_property
    def static(self) -> Real:
        """Displacement (L,), m/N, under a unit load on each wheel, without the first values."""
        both = self.direct + self.cross
        static = np.zeros(len(both))
        for n in range(1, both.shape[1]):
            static += np.roll(both[:, n], n)
        return static

    def preload(self, wheel_load: float, dx: float, speed: float) -> Real:
        """As of ``DynamicsModel``."""
        wheels = self.model.wheelset.static_receptance().sum(axis=1)
        return np.asarray((wheels + (self.static + self.direct[:, 0]).mean()) * wheel_load)

    def start(self, wheel_load: float, step: int, dx: float, speed: float) -> Paper:
        """As of ``DynamicsModel``."""
        paper = self.model.start(wheel_load, step, dx, speed)
        first = self.direct[:, 0].copy()
        return paper._replace(
            direct=np.ascontiguousarray(self.direct),
            cross=np.ascontiguousarray(self.cross),
            rail_static=self.static * wheel_load,
            coming=np.zeros((2, self.direct.shape[1])),
            wheel_compliance=np.zeros(2),
            rail_compliance=first,
        )

    def at_speed(self, dynamics: Any, step: int, dx: float, speed: float, behind: float) -> Any:
        """Refused as of the model."""
        return self.model.at_speed(dynamics, step, dx, speed, behind)

    def prepare(self, dx: float, speed: float) -> None:
        """As of the model."""
        self.model.prepare(dx, speed)


@contextmanager
def settling_briefly() -> Iterator[None]:
    """Runs within it settle for ``SETTLING``."""
    with patch.object(simulator, "SETTLING", SETTLING):
        yield


@lru_cache(maxsize=1)
def sampled_model(sampling: Sampling, model: PaperModel, dx: float, speed: float) -> SampledModel:
    """Dynamics of a sampling."""
    direct, cross = sampling.tables(model, dx, speed)
    return SampledModel(model, direct, sampling.cross * cross)


def deflection_ripple(model: PaperModel, sampling: Sampling, dx: float, speed: float, load: float) -> float:
    """Variation along a bay of the rail's deflection under a constant load on both wheels, peak to peak, um."""
    sampled = sampled_model(sampling, model, dx, speed)
    return float(np.ptp((sampled.static + sampled.direct[:, 0]) * load) * 1e6)
