"""The simulator: a scenario in, a gap-free stream of sample blocks out, changes between two blocks."""

from __future__ import annotations

import dataclasses

import numpy as np

from ..contact.law_kernels import ContactLaw
from ..contact.solutions import ContactPatch, approach_for_force
from ..errors import InputError
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario.scenario import Scenario
from ..wheelset.reduced import COMPONENTS
from .changes import Applied, Changes, Condition, Revision
from .coupled import AHEAD, Coupled
from .handover import handover
from .instants import Contact
from .models import Models, load_models
from .preload import Loading
from .speed import Course, Stretch
from .superposition import Superposition, followed, superposition

SETTLING = 1.0
"""Time of smooth running before step 0, s: the suspension's modes (7 and 10 Hz) decay to 1e-4 of the difference
between standing and running, which is itself below 1 % of the static load."""

CHANGEABLE = ("name", "speed", "acceleration", "speed_plan", "axle_load", "irregularities", "line_length", "loads")
"""Scenario keys that may change during a run; the models do not depend on them."""

REMEMBERED = 10_000
"""Changes that a run remembers, the latest: some 2 kB each."""


class Simulator:
    """One wheelset running along the track, block by block.

    Step 0 follows a settling phase with smooth treads, so that the stream starts in steady running. ``advance`` and
    ``apply`` may be called from different threads.
    """

    def __init__(
        self,
        scenario: Scenario,
        progress: Progress | None = None,
        models: Models | None = None,
        start: Stretch | None = None,
    ) -> None:
        """Load or build the models and settle; raises InputError if the scenario cannot be used.

        Raises ContactError, with a step below that of the start, for models that do not settle.

        ``models`` of an earlier run serve again if nothing but ``CHANGEABLE`` keys differs. ``start`` is where a run
        begins that does not begin with step 0, with the speed that is run at and the one that is approached.
        """
        self._models: Models = models or load_models(scenario, progress)
        self._check_steps(scenario)
        self._superposition = self._superposed(scenario)
        self._plan = scenario.speed_plan
        start = start or Stretch(0, 0.0, scenario.speed, scenario.speed)
        settling = round(SETTLING / (scenario.step_length / start.speed))
        smooth = Condition(Revision(0, start.step), scenario, self._models.contact_law(()), self._preload_for(scenario))
        self._coupled = Coupled(self._models, scenario.wheel_load, start.step - settling, start.speed)
        self._loading = Loading(smooth.preload)
        self._preload = np.tile(smooth.preload, (settling, 1))
        while self._coupled.next_step < start.step:  # once; again from a step without solution, which raises
            left = self._preload[self._coupled.next_step - start.step :]
            self._forces = self._coupled.run(smooth, start.speed, left)[0][-1]
        self._changes = Changes(smooth, self._models.tread_origin)
        law = self._models.contact_law(scenario.irregularities, progress, scenario.line_length)
        self._changes.add(scenario, law, smooth.preload, number=0)
        self._course = Course((start,), scenario.step_length).redirected(
            start.step, start.set_point, scenario.acceleration, scenario.speed_plan
        )
        self._history: tuple[Applied, ...] = (Applied(smooth.revision, scenario, start.set_point),)

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
    def history(self) -> tuple[Applied, ...]:
        """What the run started under, and each change that has come into force since: the latest ``REMEMBERED``."""
        return self._history

    @property
    def next_step(self) -> int:
        """Index of the next sample."""
        return self._coupled.next_step

    @property
    def time(self) -> float:
        """Simulated time of the next sample since step 0, s."""
        return self._course.time_of(self.next_step)

    @property
    def course(self) -> Course:
        """The speed from the latest block on."""
        return self._course

    @property
    def speed(self) -> float:
        """Speed of the next sample, m/s."""
        return self._course.at(self.next_step).speed

    @property
    def step_period(self) -> float:
        """Time of one step at that speed, s."""
        return self.in_force.step_length / self.speed

    @property
    def steps_per_revolution(self) -> int:
        """Steps in one turn of the wheel."""
        return self._models.steps_per_revolution

    @property
    def digest(self) -> str:
        """Digest of the scenario and of the models that it runs on."""
        return self._models.digest(self.scenario)

    @property
    def displacements(self) -> Real:
        """Displacements of the latest block, (samples, 2, 2), m: wheels and rails away from each other, by wheel."""
        return self._coupled.displacements

    def contact(self, wheel: int, row: int) -> Contact:
        """Contact of ``wheel`` (0 or 1) at sample ``row`` of the latest block; it stays good when the run goes on."""
        law, approach = self.approach(wheel, row)
        step = self.next_step - len(self.displacements) + row
        bare = law._replace(points=law.points[:0])  # tables take memory, and no part in a solution
        return Contact(wheel, step, step - self._models.tread_origin, approach, bare)

    def contact_patch(self, wheel: int, row: int) -> ContactPatch:
        """The same, solved for its pressure."""
        return self.contact(wheel, row).solve()

    def approach(self, wheel: int, row: int) -> tuple[ContactLaw, float]:
        """Contact law and approach, m, of ``wheel`` (0 or 1) at sample ``row`` of the latest block."""
        approach = self._preload[row, wheel] - self.displacements[row, :, wheel].sum()
        return self._changes.in_force.law, float(approach)

    def apply(
        self, scenario: Scenario, progress: Progress | None = None, *, not_before: int = 0, exactly: bool = False
    ) -> Revision:
        """Accept a changed scenario whole, or raise InputError and go on as before.

        The contact of changed treads is worked out first, which takes a while; what ``progress`` raises breaks it off.

        It comes into force between two blocks, at the first step from ``not_before`` on at which no irregularity that
        changes is in the contact patch; after one turn of the wheel at the latest, with a ``handover`` if it is never
        out of it. From there on a changed load rises (``loading``), and there the ramps to a changed ``speed`` and
        torque begin, which then end their plans for good; without the plan in ``scenario`` it ends at an unchanged
        value, too. With ``exactly`` it does not wait for the contact patch, but comes where it has come before.
        """
        newest = self._changes.newest
        current = newest.scenario
        for field in dataclasses.fields(Scenario):
            if field.name not in CHANGEABLE and getattr(scenario, field.name) != getattr(current, field.name):
                raise InputError(f"{field.name} cannot change during a run: start a new one with the new value")
        current.loads.check_change(scenario.loads)
        self._superposed(scenario)  # refuses what cannot be, and is quick afterwards
        if scenario.speed_plan not in ((), self._plan):
            raise InputError(
                "speed_plan cannot change during a run: give speed, which ends the plan, or start a new run"
            )
        if scenario.speed != current.speed or not current.speed_plan:
            scenario = dataclasses.replace(scenario, speed_plan=())
        if scenario.speed != current.speed and not self._models.dynamics.changes_speed:
            raise InputError(f"speed cannot change in {current.dynamics} dynamics: start a new run, or use causal")
        self._check_steps(scenario)
        shape, line = scenario.irregularities, scenario.line_length
        same = (shape, line) == (current.irregularities, current.line_length)
        law = newest.law if same else self._models.contact_law(shape, progress, line)
        return self._changes.add(scenario, law, self._preload_for(scenario), not_before=not_before, exactly=exactly)

    def advance(self, steps: int) -> SampleBlock:
        """The next ``steps`` samples, or fewer where a change comes into force or the speed changes behind them.

        Raises ContactError with step and inputs if a contact problem has no solution; samples solved before that
        step are returned first.
        """
        if steps < 1:
            raise ValueError(f"steps = {steps}: give at least 1")
        longest = self._models.dynamics.longest_run - SETTLING
        if self.time + steps * self.step_period > longest:
            raise InputError(f"{self.in_force.dynamics} dynamics runs for {longest:g} s at most: use causal for longer")
        first = end = self.next_step
        while end == first:  # again for a change that was accepted between the two
            self._install_due()
            end = self._changes.claim(min(first + steps, self._course.border(first)))
        condition = self._changes.in_force
        scenario, on = condition.scenario, self._course.at(first)
        ahead = [stretch.speed for stretch in self._course.ahead(first)[:AHEAD]]
        rows = np.arange(first - on.step, end - on.step, dtype=np.float64)
        times = on.time + rows * (scenario.step_length / on.speed)
        self._preload = self._loading.at(times)
        forces, stress = self._coupled.run(condition, on.speed, self._preload, ahead)
        self._forces = forces[-1]
        # In memory one signal after the other, as who takes them in wants them.
        stresses = np.zeros((len(scenario.output.stress_nodes) * len(COMPONENTS), len(forces)))
        stresses[self._models.dynamics.stress_rows] = stress.T
        if self._superposition is not None:
            stresses += self._superposition.stresses(times[: len(forces)])
        return SampleBlock(
            first_step=first,
            time=self._course.time_of(first),
            step_period=scenario.step_length / on.speed,
            speed=on.speed,
            position=first * scenario.step_length,
            revision=condition.revision.number,
            forces=forces,
            stresses=stresses.reshape(-1, len(COMPONENTS), len(forces)).transpose(2, 0, 1),
            nodes=scenario.output.stress_nodes,
        )

    def _preload_for(self, scenario: Scenario) -> Real:
        smooth = self._models.contact_law(())
        load = scenario.wheel_load
        preload: Real = self._models.dynamics.preload(load, scenario.step_length, scenario.speed)
        return preload + [approach_for_force(smooth, wheel, 0, 0, load) for wheel in (0, 1)]

    def _check_steps(self, scenario: Scenario) -> None:
        """Raise InputError for a speed at which the time of a step is more than the dynamics can follow."""
        slowest = min([scenario.speed, *(each.speed for each in scenario.speed_plan)])
        longest = self._models.dynamics.longest_step
        if scenario.step_length > longest * slowest * (1 + 1e-9):
            raise InputError(
                f"speed = {slowest:g} m/s makes steps of {1e3 * scenario.step_length / slowest:.3g} ms, and track.line "
                f"holds up to {1e3 * longest:g} ms: give a speed from {scenario.step_length / longest:g} m/s, or a "
                f"step_length up to {longest * slowest:g} m"
            )

    def _superposed(self, scenario: Scenario) -> Superposition | None:
        """What the loads of a scenario superpose; raises InputError."""
        models = self._models
        return superposition(scenario.loads, models.wheelset, models.reduced, scenario.output.stress_nodes)

    def _install_due(self) -> None:
        """Conditions that are due; course and loading from here on if they are others."""
        before, time, law = self.in_force, self.time, self._changes.in_force.law
        self._loading = self._loading.over(time)
        for condition in self._changes.due(self.next_step):
            if not condition.clear:
                where = self.next_step, self._models.tread_origin
                by = handover(law, condition.law, *where, self._forces, time, self.step_period)
                self._loading = self._loading.raised(by)
            now, law = condition.scenario, condition.law
            if any(getattr(now, key) != getattr(before, key) for key in ("speed", "acceleration", "speed_plan")):
                set_point = self._course.at(self.next_step).set_point if now.speed_plan else now.speed
                self._course = self._course.redirected(self.next_step, set_point, now.acceleration, now.speed_plan)
            self._loading = self._loading.changed(time, condition.preload)
            if now.loads != before.loads:
                self._superposition = followed(self._superposition, self._superposed(now), time, now.loads)
            before = now
            if condition.revision.number > self.history[-1].revision.number:
                applied = Applied(condition.revision, now, self._course.at(self.next_step).set_point)
                self._history = (*self._history, applied)[-REMEMBERED:]
