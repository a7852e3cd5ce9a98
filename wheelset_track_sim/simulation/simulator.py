"""The simulator: a scenario in, a gap-free stream of sample blocks out, changes between two blocks."""

from __future__ import annotations

import dataclasses
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..contact.law import ContactPatch, approach_for_force, solve_patch
from ..contact.law_kernels import ContactLaw
from ..errors import ContactError, InputError
from ..scenario import Scenario
from .block import COMPONENTS, SampleBlock
from .coupled_kernels import run
from .models import Models, load_models
from .passage import first_clear_step

Progress = Callable[[str, float], None]

SETTLING = 1.0
"""Time of smooth running before step 0, s: the suspension's modes (7 and 10 Hz) decay to 1e-4 of the difference
between standing and running, which is itself below 1 % of the static load."""

CHANGEABLE = ("name", "speed", "axle_load", "irregularities")
"""Scenario keys that may change during a run."""


@dataclass(frozen=True)
class Revision:
    """An accepted change: its number, and the step from which it is in force."""

    number: int
    step: int


@dataclass(frozen=True)
class _Pending:
    revision: Revision
    scenario: Scenario
    law: ContactLaw
    preload: np.ndarray


class Simulator:
    """One wheelset running along the track, block by block.

    Step 0 follows a settling phase with smooth treads, so that the stream starts in steady running. ``advance`` and
    ``apply`` may be called from different threads.
    """

    def __init__(self, scenario: Scenario, progress: Progress | None = None, models: Models | None = None) -> None:
        """Load or build the models and settle; raises InputError if the scenario cannot be used.

        ``models`` of an earlier run serve again if nothing but ``CHANGEABLE`` keys differs.
        """
        self._models: Models = models or load_models(scenario, progress)
        self._lock = threading.Lock()
        self._queue: deque[_Pending] = deque()
        self._scenario, self._law = scenario, self._models.contact_law(())
        self._preload = self._preload_for(scenario)
        self._revision = 0
        self._next = -round(SETTLING / scenario.step_period)
        self._base = (0, 0.0)  # a step and its time, from which the time adds up
        load, speed = scenario.wheel_load, scenario.speed
        self._speed_behind = self._dynamics_speed = speed
        self._dynamics = self._models.dynamics.start(load, self._next, scenario.step_length, speed)
        self._horizon = 0
        self._run(-self._next)
        self._enqueue(0, scenario, self._models.contact_law(scenario.irregularities, progress))

    @property
    def scenario(self) -> Scenario:
        """The scenario as last accepted; it may come into force a little later."""
        with self._lock:
            return self._queue[-1].scenario if self._queue else self._scenario

    @property
    def in_force(self) -> Scenario:
        """The scenario in force in the latest block, or at the start."""
        return self._scenario

    @property
    def models(self) -> Models:
        """The models that the run stands on."""
        return self._models

    @property
    def revision(self) -> int:
        """Number of the change in force."""
        return self._revision

    @property
    def next_step(self) -> int:
        """Index of the next sample."""
        return self._next

    @property
    def time(self) -> float:
        """Simulated time of the next sample since step 0, s."""
        step, time = self._base
        return time + (self._next - step) * self.step_period

    @property
    def speed(self) -> float:
        """Speed in force, m/s."""
        return self._scenario.speed

    @property
    def step_period(self) -> float:
        """Time of one step at the speed in force, s."""
        return self._scenario.step_period

    @property
    def steps_per_revolution(self) -> int:
        """Steps in one turn of the wheel."""
        return self._models.steps_per_revolution

    @property
    def digest(self) -> str:
        """Digest of the scenario and of the models that it runs on."""
        return self._models.digest(self.scenario)

    @property
    def displacements(self) -> NDArray[np.float64]:
        """Displacements of the latest block, (samples, 2, 2), m: wheels and rails away from each other, by wheel."""
        return self._xi

    def contact_patch(self, wheel: int, row: int) -> ContactPatch:
        """Contact of ``wheel`` (0 or 1) at sample ``row`` of the latest block, solved for its pressure."""
        step = self._next - len(self._xi) + row
        approach = self._preload[wheel] - self._xi[row, :, wheel].sum()
        return solve_patch(self._law, wheel, step - self._models.tread_origin, step, approach)

    def apply(self, scenario: Scenario) -> Revision:
        """Accept a changed scenario whole, or raise InputError and go on as before.

        It comes into force between two blocks, at the first step at which no irregularity that changes is in the
        contact patch; after one turn of the wheel at the latest.
        """
        current = self.scenario
        for field in dataclasses.fields(Scenario):
            if field.name not in CHANGEABLE and getattr(scenario, field.name) != getattr(current, field.name):
                raise InputError(f"{field.name} cannot change during a run: start a new one with the new value")
        if scenario.speed != current.speed and not self._models.dynamics.changes_speed:
            raise InputError(f"speed cannot change in {current.dynamics} dynamics: start a new run, or use causal")
        same = scenario.irregularities == current.irregularities
        law = self._newest_law() if same else self._models.contact_law(scenario.irregularities)
        return self._enqueue(None, scenario, law)

    def advance(self, steps: int) -> SampleBlock:
        """The next ``steps`` samples, or fewer where a change comes into force behind them.

        Raises ContactError with step and inputs if a contact problem has no solution; samples solved before that
        step are returned first.
        """
        if steps < 1:
            raise ValueError(f"steps = {steps}: give at least 1")
        longest = self._models.dynamics.longest_run - SETTLING
        if self.time + steps * self.step_period > longest:
            raise InputError(
                f"{self._scenario.dynamics} dynamics runs for {longest:g} s at most: use causal for longer"
            )
        self._install_due()
        first = self._next
        with self._lock:
            end = first + steps
            for pending in self._queue:
                if pending.revision.number != self._revision and pending.revision.step < end:
                    end = pending.revision.step
                    break
            self._horizon = end
        time = self.time
        forces, stresses = self._run(end - first)
        return SampleBlock(
            first_step=first,
            time=time,
            step_period=self.step_period,
            speed=self.speed,
            position=first * self._scenario.step_length,
            revision=self._revision,
            forces=forces,
            stresses=stresses,
            nodes=self._scenario.output.stress_nodes,
        )

    def _preload_for(self, scenario: Scenario) -> np.ndarray:
        smooth = self._models.contact_law(())
        load = scenario.wheel_load
        displaced = self._models.dynamics.preload(load, scenario.step_length, scenario.speed)
        return displaced + approach_for_force(smooth, 0, 0, 0, load)

    def _newest_law(self) -> ContactLaw:
        with self._lock:
            return self._queue[-1].law if self._queue else self._law

    def _enqueue(self, number: int | None, scenario: Scenario, law: ContactLaw) -> Revision:
        preload = self._preload_for(scenario)
        with self._lock:
            last = self._queue[-1] if self._queue else None
            earliest = max(self._horizon, last.revision.step if last else 0)
            before = last.law if last else self._law
            step = first_clear_step(before, law, earliest, self._models.tread_origin)
            newest = last.revision.number if last else self._revision
            revision = Revision(newest + 1 if number is None else number, step)
            self._queue.append(_Pending(revision, scenario, law, preload))
        return revision

    def _install_due(self) -> None:
        with self._lock:
            while self._queue and self._queue[0].revision.step <= self._next:
                due = self._queue.popleft()
                if due.scenario.speed != self._scenario.speed:
                    self._base = (self._next, self.time)
                self._scenario, self._law, self._preload = due.scenario, due.law, due.preload
                self._revision = due.revision.number

    def _run(self, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Samples of the next ``steps`` steps; installs a scenario that is due on the way."""
        model = self._models.dynamics
        forces = np.empty((steps, 2))
        stress = np.empty((steps, len(model.stress_rows)))
        xi = np.empty((steps, 2, 2))
        done = 0
        while done < steps:
            self._install_due()
            stop = steps
            with self._lock:
                if self._queue:
                    stop = min(stop, done + self._queue[0].revision.step - self._next)
            stop = self._set_speed(done, stop)
            part = slice(done, stop)
            solved = run(
                self._dynamics,
                self._law,
                self._preload,
                self._models.tread_origin,
                self._next,
                forces[part],
                stress[part],
                xi[part],
            )
            self._next += solved
            done += solved
            if done < stop:
                if done == 0:
                    self._refuse(forces, xi)
                break
        self._xi = xi[:done]
        stresses = np.zeros((done, len(self._scenario.output.stress_nodes) * len(COMPONENTS)))
        stresses[:, model.stress_rows] = stress[:done]
        return forces[:done], stresses.reshape(done, -1, len(COMPONENTS))

    def _set_speed(self, done: int, stop: int) -> int:
        """Coefficients for the speed in force; the one step at which it changes has its own, and is run alone."""
        speed, dx = self._scenario.speed, self._scenario.step_length
        if speed == self._dynamics_speed == self._speed_behind:
            return stop
        changes = speed != self._dynamics_speed
        self._speed_behind = self._dynamics_speed if changes else speed
        self._dynamics_speed = speed
        self._dynamics = self._models.dynamics.at_speed(self._dynamics, dx, speed, self._speed_behind)
        return done + 1 if changes else stop

    def _refuse(self, forces: np.ndarray, xi: np.ndarray) -> None:
        approach = self._preload - xi[0].sum(axis=0)
        raise ContactError(
            f"the contact problem of step {self._next} has no solution: approach of wheel 1 and 2 is "
            f"{approach[0]:g} and {approach[1]:g} m, beyond what half-spaces of this size can carry"
        )
