"""The models that a scenario names, loaded from the cache or built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..contact.geometry import ContactGeometry
from ..contact.law import build_contact_law, law_of_surfaces, rolling_surfaces
from ..contact.law_kernels import ContactLaw
from ..contact.solutions import approach_for_force
from ..dynamics.causal import causal_model
from ..dynamics.interface import DynamicsModel
from ..dynamics.line import line_model
from ..dynamics.paper import paper_model
from ..dynamics.running_wheelset import running_wheelset, truncated
from ..irregularities import Irregularity, line_steps
from ..runtime.arrays import Real
from ..runtime.cache import digest
from ..runtime.jit import compile_ahead, compiled_meanwhile
from ..runtime.progress import Progress
from ..scenario import Scenario
from ..scenario.scenario import PAPER_BAND
from ..sensors.kinds import rows_of
from ..track.balance import moving_track
from ..track.line import track_line
from ..track.ring import MAX_FREQUENCY
from ..track.track import Track
from ..version import __version__
from ..wheelset.kinds import AnyWheelset, primary_suspension, reduce_wheelset
from ..wheelset.reduced import ReducedWheelset
from ..wheelset.vehicle import Vehicle
from .passage import FADE, faded

KERNELS = f"{__package__}.compilation"
"""Module that compiles a set of kernels when it is executed with its name."""


KEPT = 64
"""Loads and speeds whose preload is kept: for another one it takes 10 ms."""


@dataclass(eq=False)
class Models:
    """Everything that is built before a run and that changes of irregularities and speed leave as it is."""

    wheelset: AnyWheelset
    reduced: ReducedWheelset
    track: Track
    dynamics: DynamicsModel
    geometry: ContactGeometry
    step_length: float
    steps_per_revolution: int
    tread_origin: int
    """Step at which angle 0 of the treads meets the rail."""
    vehicle: Vehicle | None = None
    tables: bool | Literal["smooth"] = True
    """Which contacts have tables, as for ``build_contact_law``."""
    hardness: float = math.inf
    """Largest contact pressure, Pa."""
    tolerance: float = 0.0
    """Largest estimated error of a filtered contact force, share of the static load; 0 solves all contacts."""
    _smooth: ContactLaw | None = field(default=None, repr=False)
    _preloads: dict[tuple[float, float], Real] = field(default_factory=dict, repr=False)

    def contact_law(
        self,
        irregularities: Sequence[Irregularity],
        progress: Progress | None = None,
        line_length: float | None = None,
    ) -> ContactLaw:
        """Contact law of treads and rails with these irregularities, with a state of its own.

        Those of rails repeat after ``line_length``, m, or after as much as they need if None.
        """
        if not irregularities and self._smooth is not None:
            return with_own_state(self._smooth)
        law = build_contact_law(
            irregularities,
            self.geometry,
            self.step_length,
            self.steps_per_revolution,
            rail_steps=line_steps(irregularities, line_length, self.step_length),
            hardness=self.hardness,
            tables=self.tables,
            smooth=self._smooth,
            filtered=self.tolerance > 0.0,
            progress=progress,
        )
        if not irregularities:
            self._smooth = law
        return with_own_state(law)

    def preload(self, wheel_load: float, speed: float) -> Real:
        """Approach (2,) m of wheel and rail without dynamics that loads each contact with ``wheel_load``, N."""
        under = wheel_load, speed
        if under not in self._preloads:
            smooth, displaced = self.contact_law(()), self.dynamics.preload(wheel_load, self.step_length, speed)
            indented = [approach_for_force(smooth, wheel, 0, 0, wheel_load) for wheel in (0, 1)]
            while len(self._preloads) >= KEPT:
                self._preloads.pop(next(iter(self._preloads)))
            self._preloads[under] = displaced + indented
        return self._preloads[under]

    def fade_law(
        self, before: Scenario, after: Scenario, first: int, speed: float | None = None
    ) -> tuple[ContactLaw, int]:
        """Contact law of surfaces that fade from those of ``before`` to those of ``after``, and its length in steps.

        It begins at the step ``first``; row 0 of its treads is ``len(law.x)`` before. It lasts ``FADE`` at ``speed``,
        m/s, or at the highest speed that the scenarios name: the length does not depend on when a change is accepted.
        """
        speeds = (before.speed, after.speed, *(point.speed for point in (*before.speed_plan, *after.speed_plan)))
        steps = round(FADE * (speed or max(speeds)) / self.step_length)
        old, new = (
            rolling_surfaces(
                each.irregularities,
                self.geometry,
                self.step_length,
                self.steps_per_revolution,
                line_steps(each.irregularities, each.line_length, self.step_length),
            )
            for each in (before, after)
        )
        surfaces = faded(old, new, first, steps, self.tread_origin)
        law = law_of_surfaces(surfaces, self.geometry, self.step_length, hardness=self.hardness, tables=False)
        return law, steps

    def digest(self, scenario: Scenario) -> str:
        """Digest of a scenario with the content of its models, and of the program's version."""
        models = [self.wheelset, self.track, *([self.vehicle] if self.vehicle else [])]
        return digest([__version__, scenario.to_mapping(), *models, self.geometry])

    @property
    def settling(self) -> float:
        """Time, s, in which what stands on the primary suspension comes to rest; 0 if that is nothing."""
        return 0.0 if self.vehicle is None else self.vehicle.settling(*primary_suspension(self.wheelset))


def with_own_state(law: ContactLaw) -> ContactLaw:
    """The same law for another run: what its solutions leave behind is not shared."""
    return law._replace(in_contact=np.zeros_like(law.in_contact))


def compile_for_changes(scenario: Scenario) -> None:
    """Begin to compile, beside the run of a scenario, what a change of its irregularities may need."""
    if scenario.dynamics != "paper":
        compile_ahead(KERNELS, f"{_steps(scenario)}-changes")


def _steps(scenario: Scenario) -> str:
    return "causal" if scenario.track.line is None else "line"


def load_models(
    scenario: Scenario, progress: Progress | None = None, *, tables: bool | Literal["smooth"] = True
) -> Models:
    """Models of a scenario, ``tables`` as for ``build_contact_law``."""
    if scenario.dynamics == "paper":
        return _models(scenario, progress, tables)
    with compiled_meanwhile(KERNELS, _steps(scenario)):
        models = _models(scenario, progress, tables)
        models.contact_law((), progress)
    return models


def _models(scenario: Scenario, progress: Progress | None, tables: bool | Literal["smooth"]) -> Models:
    wheelset, track, dx = scenario.touched_wheelset, scenario.track, scenario.step_length
    reduced = reduce_wheelset(wheelset, progress, scenario.vehicle, rows_of(scenario.sensors))
    nodes, band, lag_zero = scenario.output.stress_nodes, scenario.max_frequency, scenario.at_lag_zero
    dynamics: DynamicsModel
    if scenario.dynamics == "paper":
        printed = band or PAPER_BAND
        dynamics = paper_model(reduced, track, nodes, max_frequency=printed, lag_zero=lag_zero, progress=progress)
    else:
        kept = reduced if band is None else truncated(reduced, band)
        if track.line is not None:
            dynamics = line_model(running_wheelset(kept, nodes, lag_zero), track_line(track), lag_zero)
        else:
            limit = min(band or MAX_FREQUENCY, MAX_FREQUENCY)
            running = moving_track(track, dx, max_frequency=limit, progress=progress)
            dynamics = causal_model(kept, running, nodes, lag_zero)
    return Models(
        wheelset=wheelset,
        reduced=reduced,
        track=track,
        dynamics=dynamics,
        geometry=scenario.geometry,
        step_length=dx,
        steps_per_revolution=scenario.steps_per_revolution,
        tread_origin=scenario.tread_origin,
        vehicle=scenario.vehicle,
        tables=tables,
        hardness=scenario.contact.largest_pressure,
        tolerance=scenario.contact.largest_estimate,
    )
