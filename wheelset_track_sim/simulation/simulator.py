"""The simulator: a scenario in, a gap-free stream of sample blocks out, changes between two blocks."""

from __future__ import annotations

import copy
import dataclasses
import math
from contextlib import suppress
from functools import partial
from typing import cast

import numpy as np

from ..contact.law_kernels import ContactLaw
from ..contact.solutions import ContactPatch
from ..errors import InputError
from ..runtime.arrays import Real
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario import Event, Scenario
from ..sensors.kinds import rows_of
from ..wheelset.around import Around
from ..wheelset.reduced import COMPONENTS
from .agenda import after, next_due, next_step, rehearsed, step_of
from .changes import Applied, Changes, Condition, OvertakenError, Revision
from .coupled import AHEAD, Coupled
from .instants import Contact
from .laws_ahead import LawsAhead
from .limits import warn_of_limits
from .models import Models, load_models
from .passage import passage
from .preload import Loading
from .settling import SETTLING, Settled, Settling, settle
from .speed import Course, Stretch, course_of
from .superposition import Superposition, followed, superposition

CHANGEABLE = (
    "name",
    "speed",
    "acceleration",
    "speed_plan",
    "axle_load",
    "irregularities",
    "line_length",
    "loads",
    "settle_on",
    "events",
)
"""Scenario keys that may change during a run; the models do not depend on them."""

LEAD = 10.0
"""Time before an event at which the contact of its surfaces begins to be worked out, s."""
REMEMBERED = 10_000
"""Changes that a run remembers, the latest: some 2 kB each."""


class Simulator:
    """One wheelset running along the track, block by block.

    A simulator is constructed, which builds its models; settled, which runs it on its surfaces until it is steady; and
    advanced. ``advance`` and ``apply`` may be called from different threads.

    Parameters
    ----------
    scenario
        What is simulated.
    progress
        Called with stage and fraction while models are built.
    models
        Models of an earlier run, which serve again if nothing but ``CHANGEABLE`` keys differs.
    start
        Where a run begins that does not begin with step 0, with its speed and the speed that it approaches.

    Examples
    --------
    >>> simulator = Simulator(load_scenario("undamaged"))
    >>> settled = simulator.settle()
    >>> block = simulator.advance(2713)  # one turn of the wheel
    >>> block.forces.shape, block.stresses.shape
    ((2713, 2), (2713, 3, 6))
    """

    def __init__(
        self,
        scenario: Scenario,
        progress: Progress | None = None,
        models: Models | None = None,
        start: Stretch | None = None,
    ) -> None:
        """Load or build the models and the contact of treads and rails; nothing is run yet."""
        self._models: Models = models or load_models(scenario, progress)
        if len(rows_of(scenario.sensors)) != self._models.dynamics.sensor_rows:
            raise InputError("the models were built for other sensors: build them anew for this scenario")
        warn_of_limits(scenario, self._models.reduced)
        self._superposition = self._superposed(scenario)
        self._plan = scenario.speed_plan
        self._start = start or Stretch(0, 0.0, scenario.speed, scenario.speed)
        self._smooth = self._models.contact_law(())
        law = self._models.contact_law(scenario.irregularities, progress, scenario.line_length)
        begun = scenario.settles_on_surfaces
        revision, origin = Revision(0, self._start.step), self._models.tread_origin
        preload = self._models.preload(scenario.wheel_load, scenario.speed)
        first = Condition(revision, scenario, law if begun else self._smooth, preload, self._start.step, origin)
        self._coupled: Coupled | None = None
        self._loading = Loading(preload)
        self._preload = np.empty((0, 2))
        self._changes = Changes(first, origin)
        if not begun:
            fade = partial(self._models.fade_law, dataclasses.replace(scenario, irregularities=()), scenario)
            self._changes.add(scenario, law, preload, fade, number=0)
        self._course = course_of(scenario, self._start)
        self._laws = LawsAhead(self._models)
        self._coming: Event | None = None  # whose surfaces have been given to be worked out
        for coming in rehearsed(scenario, self._course):
            self._superposed(coming)
        self._first = first
        self._history: tuple[Applied, ...] = (Applied(revision, scenario, self._start.set_point),)

    def settle(self, settled: Settled | None = None) -> Settled:
        """Run until the run is steady, or begin from a settled state; ``advance`` does it if need be.

        The run settles on smooth surfaces first and then on those of the scenario, unless its ``settle_on`` is smooth.

        Parameters
        ----------
        settled
            What an earlier call returned, of this simulator or of another one on the same models, with the same load,
            start and speed; then nothing is run.

        Returns
        -------
        Settled
            The state at the start of the run. It can be kept, and simulators can begin from it any number of times.

        Raises
        ------
        ContactError
            With a step below that of the start, for models that do not settle.
        InputError
            If ``settled`` belongs to other models, or to another load, start or speed.
        ValueError
            If the run has begun.
        """
        if self._coupled is not None:
            raise ValueError("the run has begun: settle a new simulator")
        if settled is None:
            settled = settle(self._models, self._first, self._smooth, self.settling)
        settled.check(self.settling, self._models)
        self._coupled = settled.coupled.copy()
        self._first.law.in_contact[...] = settled.in_contact
        return settled

    @property
    def settling(self) -> Settling:
        """What the run settles under: simulators on the same models share a settled state if this is equal."""
        scenario, start = self._first.scenario, self._start
        on = (scenario.irregularities, scenario.line_length) if scenario.settles_on_surfaces else ((), None)
        return Settling(scenario.wheel_load, start.step, start.speed, on)

    def branch(self) -> Simulator:
        """The same run, settled, which goes on by itself: what is applied to one of both does not change the other."""
        if self._coupled is None:
            self.settle()
        branched = copy.copy(self)
        branched._coupled = cast("Coupled", self._coupled).copy()
        branched._changes = self._changes.copy()
        return branched

    @property
    def scenario(self) -> Scenario:
        """The scenario of the last accepted change, which may take effect a little later."""
        return self._changes.newest.scenario

    @property
    def accepted(self) -> tuple[Scenario, Revision]:
        """The scenario as last accepted, and its revision."""
        newest = self._changes.newest
        return newest.scenario, newest.revision

    @property
    def changed_from(self) -> int:
        """First step of its surfaces: that of its revision, or the end of the fade to them."""
        return self._changes.newest.from_step

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
        """The start of the run and each change that has taken effect since: the latest ``REMEMBERED``."""
        return self._history

    @property
    def next_step(self) -> int:
        """Index of the next sample."""
        return self._start.step if self._coupled is None else self._coupled.next_step

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
        return np.empty((0, 2, 2)) if self._coupled is None else self._coupled.displacements

    def contact(self, wheel: int, row: int) -> Contact:
        """Contact of ``wheel`` (0 or 1) at sample ``row`` of the latest block; it stays good when the run goes on."""
        law, approach = self.approach(wheel, row)
        step = self.next_step - len(self.displacements) + row
        bare = law._replace(points=law.points[:0])  # tables take memory, and no part in a solution
        turn = self.steps_per_revolution
        angle = (step - self._models.tread_origin) % turn * (2 * math.pi / turn)
        return Contact(wheel, step, step - self._changes.in_force.tread_origin, angle, approach, bare)

    def contact_patch(self, wheel: int, row: int) -> ContactPatch:
        """The same, solved for its pressure."""
        return self.contact(wheel, row).solve()

    def approach(self, wheel: int, row: int) -> tuple[ContactLaw, float]:
        """Contact law and approach, m, of ``wheel`` (0 or 1) at sample ``row`` of the latest block."""
        approach = self._preload[row, wheel] - self.displacements[row, :, wheel].sum()
        return self._changes.in_force.law, float(approach)

    def apply(
        self,
        scenario: Scenario,
        progress: Progress | None = None,
        *,
        not_before: int = 0,
        exactly: bool = False,
        base: Scenario | None = None,
        event: Event | None = None,
    ) -> Revision:
        """Accept a changed scenario whole, or raise InputError and go on as before.

        The contact of changed treads is worked out first, which takes a while; what ``progress`` raises breaks it off.

        It takes effect between two blocks, at the first step from ``not_before`` on at which no irregularity that
        changes is in the contact patch. If there is none within a turn of the wheel, the surfaces fade (``passage``).
        From that step on a changed load rises (``preload``), and the ramps to a changed ``speed`` and torque begin,
        which then end their plans for good; without the plan in ``scenario`` it ends at an unchanged value, too. With
        ``exactly`` it does not wait for the contact patch, but takes effect at ``not_before``, where it has done so
        before.

        Events of a run are changes, too: ``base`` is the scenario from which this change was made, and OvertakenError
        is raised if it is not the one accepted last any more. ``event`` is what made the change. New ``events`` of the
        scenario must not be in the past.
        """
        while True:
            newest = self._changes.newest
            if base is not None and newest.scenario is not base:
                raise OvertakenError("another change came first: try again")
            try:
                return self._accept(newest, scenario, progress, not_before, exactly, event)
            except OvertakenError:
                if base is not None:
                    raise

    def _accept(
        self,
        newest: Condition,
        scenario: Scenario,
        progress: Progress | None,
        not_before: int,
        exactly: bool,
        event: Event | None,
    ) -> Revision:
        """Accept a change of the condition ``newest``; raises OvertakenError if another one came first."""
        current = newest.scenario
        for field in dataclasses.fields(Scenario):
            if field.name not in (*CHANGEABLE, "sensors") and getattr(scenario, field.name) != getattr(
                current, field.name
            ):
                raise InputError(f"{field.name} cannot change during a run: start a new one with the new value")
        current.check_change(scenario)
        self._superposed(scenario)  # refuses what cannot be, and is quick afterwards
        if scenario.speed_plan not in ((), self._plan):
            raise InputError(
                "speed_plan cannot change during a run: give speed, which ends the plan, or start a new run"
            )
        if scenario.speed != current.speed or not current.speed_plan:
            scenario = dataclasses.replace(scenario, speed_plan=())
        shape, line = scenario.irregularities, scenario.line_length
        same = (shape, line) == (current.irregularities, current.line_length)
        due: list[int] = []
        if event is None and scenario.events != current.events:
            due = [step_of(each, scenario, self._course) for each in scenario.events if each not in current.events]
            for coming in rehearsed(scenario, self._course):
                self._superposed(coming)
        law = newest.law if same else self._laws.law(shape, line, progress)
        if not same:
            self._prepare(newest.law, law)
        fade = partial(self._models.fade_law, current, scenario)
        preload = self._models.preload(scenario.wheel_load, scenario.speed)
        return self._changes.add(
            scenario, law, preload, fade, base=newest, event=event, due=due, not_before=not_before, exactly=exactly
        )

    def require(self, steps: int) -> None:
        """Raise InputError if the dynamics cannot run for ``steps`` more steps."""
        longest = self._models.dynamics.longest_run - SETTLING
        if self.time + steps * self.step_period > longest:
            raise InputError(f"{self.in_force.dynamics} dynamics runs for {longest:g} s at most: use causal for longer")

    def advance(self, steps: int) -> SampleBlock:
        """Simulate the next ``steps`` samples, or fewer if a change takes effect or the speed changes after them.

        A simulator that is not settled yet is settled first. Raises ContactError with step and inputs if a contact
        problem has no solution; samples solved before that step are returned first.
        """
        if steps < 1:
            raise ValueError(f"steps = {steps}: give at least 1")
        self.require(steps)
        if self._coupled is None:
            self.settle()
        coupled = cast("Coupled", self._coupled)
        first = end = coupled.next_step
        while end == first:  # again for a change that was accepted between the two
            self._happen()
            self._install_due()
            end = self._changes.claim(
                min(first + steps, self._course.border(first)),
                lambda scenario: max(first, next_step(scenario, self._course)),
            )
        condition = self._changes.in_force
        scenario, on = condition.scenario, self._course.at(first)
        ahead = [stretch.speed for stretch in self._course.ahead(first)[:AHEAD]]
        rows = np.arange(first - on.step, end - on.step, dtype=np.float64)
        times = on.time + rows * (scenario.step_length / on.speed)
        self._preload = self._loading.at(times)
        forces, stress = coupled.run(condition, on.speed, self._preload, ahead)
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
            contacts=coupled.contacts,
            sensors=self._sensed(first, coupled.signals),
        )

    @property
    def constant_stress(self) -> Real:
        """What is the same all around the axle at all times, of press fits and given stresses, (nodes, 6), Pa."""
        nodes = len(self.scenario.output.stress_nodes)
        if self._superposition is None:
            return np.zeros((nodes, len(COMPONENTS)))
        return Around.even(self._superposition.constant.mean).at(self._superposition.angles)

    def _sensed(self, first: int, signals: Real) -> dict[str, Real]:
        """True values (n, channels) of each sensor, by topic, from the rows (n, rows) that all of them read."""
        sensors = self.scenario.sensors
        if not sensors:
            return {}
        angles = np.empty(0)
        if any(each.turning for each in sensors):
            turn = self.steps_per_revolution
            steps = np.arange(first, first + len(signals)) - self._models.tread_origin
            angles = 2 * math.pi / turn * (steps % turn).astype(np.float64)
        place = {row: at for at, row in enumerate(rows_of(sensors))}
        return {
            each.topic: each.signals(_columns(signals, [place[row] for row in each.rows]), angles) for each in sensors
        }

    def _prepare(self, before: ContactLaw, law: ContactLaw) -> None:
        """Compile what steps under a law, or a fade to it, call: the run would wait for the compiler."""
        solves = len(law.nested[0].element) > 0
        if self._coupled and (solves or passage(before, law, self.next_step, self._models.tread_origin) is None):
            self._coupled.prepare(law)

    def _superposed(self, scenario: Scenario) -> Superposition | None:
        """What the loads of a scenario superpose; raises InputError."""
        models = self._models
        return superposition(scenario.loads, models.wheelset, models.reduced, scenario.output.stress_nodes)

    def _happen(self) -> None:
        """Accept the changes of all events that are due, and have the contact of the next one worked out."""
        while (due := next_due(base := self.scenario, self._course)) is not None:
            here, event = self.next_step, due.event
            if due.step > here:
                if event is not self._coming and (due.step - here) * self.step_period < LEAD:
                    self._coming = event
                    coming = event.at(base, due.step)[0].get("irregularities", base.irregularities)
                    if coming != base.irregularities:
                        self._laws.begin(coming, base.line_length)
                return
            with suppress(OvertakenError):
                self.apply(after(base, event, here, self._course), base=base, event=event)

    def _install_due(self) -> None:
        """Conditions that are due; course and loading from here on if they are others."""
        before, time = self.in_force, self.time
        self._loading = self._loading.over(time)
        for condition in self._changes.due(self.next_step):
            now = condition.scenario
            if any(getattr(now, key) != getattr(before, key) for key in ("speed", "acceleration", "speed_plan")):
                set_point = self._course.at(self.next_step).set_point if now.speed_plan else now.speed
                self._course = self._course.redirected(self.next_step, set_point, now.acceleration, now.speed_plan)
            self._loading = self._loading.changed(time, condition.preload)
            if now.loads != before.loads:
                self._superposition = followed(self._superposition, self._superposed(now), time, now.loads)
            before = now
            if condition.revision.number > self.history[-1].revision.number:
                set_point = self._course.at(self.next_step).set_point
                applied = Applied(condition.revision, now, set_point, condition.event)
                self._history = (*self._history, applied)[-REMEMBERED:]


def _columns(signals: Real, places: list[int]) -> Real:
    """Columns of the signals (n, rows), which are not copied if they are side by side."""
    first, count = places[0], len(places)
    side_by_side = places == [*range(first, first + count)]
    return signals[:, first : first + count] if side_by_side else signals[:, places]
