"""The simulator: a scenario in, a gap-free stream of sample blocks out, changes between two blocks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..contact.law import ContactPatch, approach_for_force, solve_patch
from ..errors import InputError
from ..scenario import Scenario
from .block import COMPONENTS, SampleBlock
from .changes import Changes, Condition
from .changes import Revision as Revision
from .coupled import Coupled
from .finite import require_finite
from .models import Models, load_models

Progress = Callable[[str, float], None]

SETTLING = 1.0
"""Time of smooth running before step 0, s: the suspension's modes (7 and 10 Hz) decay to 1e-4 of the difference
between standing and running, which is itself below 1 % of the static load."""

CHANGEABLE = ("name", "speed", "axle_load", "irregularities")
"""Scenario keys that may change during a run."""


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
        settling = round(SETTLING / scenario.step_period)
        smooth = Condition(Revision(0, 0), scenario, self._models.contact_law(()), self._preload_for(scenario))
        self._coupled = Coupled(self._models, scenario.wheel_load, -settling, scenario.speed)
        self._coupled.run(smooth, scenario.speed, settling)
        self._changes = Changes(smooth, self._models.tread_origin)
        law = self._models.contact_law(scenario.irregularities, progress)
        self._changes.add(scenario, law, smooth.preload, number=0)
        self._base = (0, 0.0)  # a step and its time, from which the time adds up

    @property
    def scenario(self) -> Scenario:
        """The scenario as last accepted; it may come into force a little later."""
        return self._changes.newest.scenario

    @property
    def in_force(self) -> Scenario:
        """The scenario in force in the latest block, or at the start."""
        return self._changes.in_force.scenario

    @property
    def models(self) -> Models:
        """The models that the run stands on."""
        return self._models

    @property
    def revision(self) -> int:
        """Number of the change in force."""
        return self._changes.in_force.revision.number

    @property
    def next_step(self) -> int:
        """Index of the next sample."""
        return self._coupled.next_step

    @property
    def time(self) -> float:
        """Simulated time of the next sample since step 0, s."""
        step, time = self._base
        return time + (self.next_step - step) * self.step_period

    @property
    def speed(self) -> float:
        """Speed in force, m/s."""
        return self.in_force.speed

    @property
    def step_period(self) -> float:
        """Time of one step at the speed in force, s."""
        return self.in_force.step_period

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
        return self._coupled.displacements

    def contact_patch(self, wheel: int, row: int) -> ContactPatch:
        """Contact of ``wheel`` (0 or 1) at sample ``row`` of the latest block, solved for its pressure."""
        xi, condition = self.displacements, self._changes.in_force
        step = self.next_step - len(xi) + row
        approach = condition.preload[wheel] - xi[row, :, wheel].sum()
        return solve_patch(condition.law, wheel, step - self._models.tread_origin, step, approach)

    def apply(self, scenario: Scenario) -> Revision:
        """Accept a changed scenario whole, or raise InputError and go on as before.

        It comes into force between two blocks, at the first step at which no irregularity that changes is in the
        contact patch; after one turn of the wheel at the latest.
        """
        newest = self._changes.newest
        current = newest.scenario
        for field in dataclasses.fields(Scenario):
            if field.name not in CHANGEABLE and getattr(scenario, field.name) != getattr(current, field.name):
                raise InputError(f"{field.name} cannot change during a run: start a new one with the new value")
        if scenario.speed != current.speed and not self._models.dynamics.changes_speed:
            raise InputError(f"speed cannot change in {current.dynamics} dynamics: start a new run, or use causal")
        same = scenario.irregularities == current.irregularities
        law = newest.law if same else self._models.contact_law(scenario.irregularities)
        return self._changes.add(scenario, law, self._preload_for(scenario))

    def advance(self, steps: int) -> SampleBlock:
        """The next ``steps`` samples, or fewer where a change comes into force behind them.

        Raises ContactError with step and inputs if a contact problem has no solution; samples solved before that
        step are returned first.
        """
        if steps < 1:
            raise ValueError(f"steps = {steps}: give at least 1")
        longest = self._models.dynamics.longest_run - SETTLING
        if self.time + steps * self.step_period > longest:
            raise InputError(f"{self.in_force.dynamics} dynamics runs for {longest:g} s at most: use causal for longer")
        self._install_due()
        condition, first, time = self._changes.in_force, self.next_step, self.time
        scenario = condition.scenario
        forces, stress = self._coupled.run(condition, scenario.speed, self._changes.claim(first + steps) - first)
        require_finite(first, forces=forces, displacements=self._coupled.displacements, stress=stress)
        # In memory one signal after the other, as who takes them in wants them.
        stresses = np.zeros((len(scenario.output.stress_nodes) * len(COMPONENTS), len(forces)))
        stresses[self._models.dynamics.stress_rows] = stress.T
        return SampleBlock(
            first_step=first,
            time=time,
            step_period=self.step_period,
            speed=self.speed,
            position=first * scenario.step_length,
            revision=condition.revision.number,
            forces=forces,
            stresses=stresses.reshape(-1, len(COMPONENTS), len(forces)).transpose(2, 0, 1),
            nodes=scenario.output.stress_nodes,
        )

    def _preload_for(self, scenario: Scenario) -> NDArray[np.float64]:
        smooth = self._models.contact_law(())
        load = scenario.wheel_load
        displaced = self._models.dynamics.preload(load, scenario.step_length, scenario.speed)
        return displaced + approach_for_force(smooth, 0, 0, 0, load)

    def _install_due(self) -> None:
        before, time = self.speed, self.time
        for condition in self._changes.due(self.next_step):
            if condition.scenario.speed != before:
                self._base = (self.next_step, time)
