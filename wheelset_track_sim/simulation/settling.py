"""How a run becomes steady before its first step.

A run begins at rest on smooth surfaces, and goes on over the scenario's own surfaces, as a train does that has been
running: on defects as soon as they are out of the contact patch, on surfaces that never leave it after a fade.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..contact.law_kernels import ContactLaw
from ..errors import InputError
from ..irregularities import Irregularity
from .changes import Condition
from .coupled import Coupled
from .models import Models
from .passage import FADE, passage

SETTLING = 1.0
"""Time of smooth running that a run settles with, s: the suspension's modes (7 and 10 Hz) decay to 1e-4 of the
difference between standing and running, which is itself below 1 % of the static load."""
LEAD = 2.0
"""Time on the scenario's surfaces before step 0, s: the bending of the axle that a defect excites decays meanwhile."""
LEAD_AFTER_FADE = 0.3
"""The same on surfaces that never leave the patch, after they have faded in, s: these excite it evenly. A vehicle takes
its own time for both (``Models.settling``)."""


class Settling(NamedTuple):
    """What a run settles under."""

    wheel_load: float
    """N on each wheel."""
    step: int
    """The first step after settling."""
    speed: float
    """m/s"""
    surfaces: tuple[tuple[Irregularity, ...], float | None]
    """Irregularities, and the length after which those of the rails repeat, m."""


@dataclass(frozen=True, eq=False)
class Settled:
    """A run in steady state, from which simulators begin."""

    under: Settling
    coupled: Coupled
    in_contact: NDArray[np.bool_]
    """Elements in contact at the last step, from which the solver of the next one goes on."""

    def check(self, under: Settling, models: Models) -> None:
        """Raise InputError unless a simulator of ``models`` can begin from it ``under`` these conditions."""
        if self.coupled.models is not models:
            raise InputError("the settled state belongs to other models: give the simulator the same models")
        for name in ("wheel_load", "step", "speed"):
            given, own = getattr(under, name), getattr(self.under, name)
            if given != own:
                raise InputError(f"the settled state has {name} = {own:g}, the run {given:g}: settle it again")
        if under.surfaces != self.under.surfaces:
            raise InputError("the settled state is of a run on other surfaces: settle it again")


def settle(models: Models, first: Condition, smooth: ContactLaw, under: Settling) -> Settled:
    """Run until the run is steady; ``first`` is what it runs under at its first step.

    Raises ContactError, with a step before the first one, for models that do not settle.
    """
    stages = _stages(models, first, smooth, under)
    coupled = Coupled(models, under.wheel_load, stages[0].from_step, under.speed)
    for stage, end in zip(stages, [*(each.from_step for each in stages[1:]), under.step], strict=True):
        while coupled.next_step < end:  # once; again from a step without solution, which raises
            coupled.run(stage, under.speed, np.tile(stage.preload, (end - coupled.next_step, 1)))
    return Settled(under, coupled.copy(), first.law.in_contact.copy())


def _stages(models: Models, first: Condition, smooth: ContactLaw, under: Settling) -> list[Condition]:
    """What a run settles on: smooth surfaces, then those of the scenario; each from a step on, up to the next."""
    dt, lead = models.step_length / under.speed, 0
    stages: list[Condition] = []
    if under.surfaces[0]:
        turn, origin = models.steps_per_revolution, models.tread_origin
        lead = max(round(max(LEAD, models.settling) / dt), turn)
        clear = passage(smooth, first.law, under.step - lead, origin)
        if clear is None:
            lead = max(round((FADE + max(LEAD_AFTER_FADE, models.settling)) / dt), turn)
            begin = under.step - lead
            plain = dataclasses.replace(first.scenario, irregularities=())
            law, steps = models.fade_law(plain, first.scenario, begin, under.speed)
            row_0, clear = begin - len(law.x), begin + steps
            stages.append(dataclasses.replace(first, law=law, from_step=begin, tread_origin=row_0))
        stages.append(dataclasses.replace(first, from_step=clear))
    begin = under.step - lead - round(SETTLING / dt)
    return [dataclasses.replace(first, law=smooth, from_step=begin, tread_origin=models.tread_origin), *stages]
