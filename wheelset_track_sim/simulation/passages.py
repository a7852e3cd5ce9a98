"""Passages of distinct defects: each once over the rail, from a run that is settled once for all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from ..errors import InputError
from ..irregularities import Irregularity
from ..runtime.progress import Progress
from ..samples.block import SampleBlock
from ..scenario import Scenario
from .models import Models, load_models
from .simulator import Simulator

BAYS = 3
"""Sleeper bays of a passage, half of them before the place where angle 0 of the treads meets the rail."""
KEPT = 16
"""Runs that are kept, one for each pair of speed and load."""


class Passages:
    """Passages of defects that are not known beforehand, some 30 in a second on one core.

    A run on the scenario's surfaces, without the defects, is settled and goes on to the beginning of the passage. It is
    kept; each passage branches off it, applies its defects and takes the steps of three bays. Force tables would take
    longer than they save, so contacts with a defect are solved, and those of rough surfaces filtered.

    The samples are those of a ``Simulator`` to which the same change is applied at that step, on the same models, bit
    for bit. A ``Simulator`` with force tables agrees within 1e-9 of the static load.

    Parameters
    ----------
    scenario
        Models, and the surfaces that all passages have in common: the run settles on them, whatever its ``settle_on``.
    progress
        Called with stage and fraction while models are built.
    models
        Models of such a scenario, with ``tables="smooth"``, that are there already.
    before, after
        Track that is passed before and behind the place where angle 0 of the treads meets the rail, m; half of three
        bays if None.

    Raises
    ------
    InputError
        If the passage begins before step 0, or for a scenario whose speed follows a plan.

    Examples
    --------
    >>> passages = Passages(load_scenario("undamaged"))
    >>> block = passages.run(load_scenario("damage_wheel_1").irregularities, speed=25.0)
    >>> len(block), block.forces.max(axis=0).shape, block.max_principal.max(axis=0).shape  # peaks in N and Pa
    (1801, (2,), (3,))
    """

    def __init__(
        self,
        scenario: Scenario,
        progress: Progress | None = None,
        models: Models | None = None,
        *,
        before: float | None = None,
        after: float | None = None,
    ) -> None:
        if scenario.speed_plan:
            raise InputError("speed_plan has no place in a passage: give speed")
        if scenario.events:
            raise InputError("events have no place in a passage: leave them out")
        half = BAYS / 2 * scenario.track.spacing
        before, after = (half if given is None else given for given in (before, after))
        self.scenario, dx = dataclasses.replace(scenario, settle_on="surfaces"), scenario.step_length
        self.first_step = round((scenario.reference_position - before) / dx)
        """First step of each passage."""
        self.steps = round((before + after) / dx) + 1
        """Steps of each passage."""
        if self.first_step < 0 or self.steps < 1:
            raise InputError(
                f"a passage from {before:g} m before to {after:g} m behind the reference position of "
                f"{scenario.reference_position:g} m is none: give a beginning behind step 0, and an end behind it"
            )
        self._models = models or load_models(scenario, progress, tables="smooth")
        self._runs: dict[tuple[float, float], Simulator] = {}

    def run(
        self, defects: Sequence[Irregularity], *, speed: float | None = None, axle_load: float | None = None
    ) -> SampleBlock:
        """Samples of one passage with ``defects`` beside the scenario's own irregularities.

        ``speed``, m/s, and ``axle_load``, N, are those of the scenario if None.

        Raises InputError for what a scenario refuses, and for defects that are in the contact patch where the passage
        begins; ContactError if a contact problem has no solution.
        """
        return self.follow(defects, speed=speed, axle_load=axle_load)[1]

    def follow(
        self, defects: Sequence[Irregularity], *, speed: float | None = None, axle_load: float | None = None
    ) -> tuple[Simulator, SampleBlock]:
        """Return the samples of ``run`` with the simulator before them, which has the contact of each sample."""
        own = self.scenario
        speed, axle_load = own.speed if speed is None else speed, own.axle_load if axle_load is None else axle_load
        run = self._run(speed, axle_load).branch()
        run.apply(dataclasses.replace(run.scenario, irregularities=(*own.irregularities, *defects)))
        if run.changed_from != self.first_step:
            raise InputError(
                f"the irregularities are in the contact patch where the passage begins, at "
                f"{self.first_step * own.step_length:g} m: give defects elsewhere, or more track before them"
            )
        block = run.advance(self.steps)
        if len(block) < self.steps:
            run.advance(1)  # from a step without solution, which raises
        return run, block

    def _run(self, speed: float, axle_load: float) -> Simulator:
        """The run at the beginning of a passage; kept."""
        under = speed, axle_load
        run = self._runs.pop(under, None)
        if run is None:
            run = Simulator(dataclasses.replace(self.scenario, speed=speed, axle_load=axle_load), models=self._models)
            run.settle()
            while run.next_step < self.first_step:
                run.advance(self.first_step - run.next_step)
        self._runs[under] = run  # at the end: the latest
        while len(self._runs) > KEPT:
            self._runs.pop(next(iter(self._runs)))
        return run
