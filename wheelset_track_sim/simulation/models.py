"""The models that a scenario names, loaded from the cache or built."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ..contact.geometry import ContactGeometry
from ..contact.law import build_contact_law
from ..contact.law_kernels import ContactLaw
from ..dynamics.causal import causal_model
from ..dynamics.interface import DynamicsModel
from ..dynamics.line import line_model
from ..dynamics.paper import paper_model
from ..dynamics.running_wheelset import running_wheelset, truncated
from ..errors import InputError
from ..irregularities import Irregularity, line_steps
from ..runtime.cache import digest
from ..runtime.jit import compiled_meanwhile
from ..runtime.progress import Progress
from ..scenario.scenario import Scenario
from ..track.balance import moving_track
from ..track.line import track_line
from ..track.ring import MAX_FREQUENCY
from ..track.track import Track, load_track
from ..version import __version__
from ..wheelset.kinds import AnyWheelset, load_any_wheelset, reduce_wheelset
from ..wheelset.reduced import ReducedWheelset
from ..wheelset.wheelset import Wheelset
from .contact_geometry import contact_geometry

KERNELS = f"{__package__}.compilation"
"""Module that compiles the kernels of a run when it is executed."""


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
    tables: bool | Literal["smooth"] = True
    """Which contacts have tables, as for ``build_contact_law``."""
    _smooth: ContactLaw | None = field(default=None, repr=False)

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
            tables=self.tables,
            progress=progress,
        )
        if not irregularities:
            self._smooth = law
        return with_own_state(law)

    def digest(self, scenario: Scenario) -> str:
        """Digest of a scenario with the content of its models, and of the program's version."""
        return digest([__version__, scenario.to_mapping(), self.wheelset, self.track, self.geometry])


def with_own_state(law: ContactLaw) -> ContactLaw:
    """The same law for another run: what its solutions leave behind is not shared."""
    return law._replace(in_contact=np.zeros_like(law.in_contact))


def described(scenario: Scenario) -> tuple[AnyWheelset, Track, ContactGeometry]:
    """Wheelset, touched where its profiles touch the rails, track and contact geometry of a scenario, to be built.

    Raises InputError for one that cannot be used.
    """
    wheelset, track = load_any_wheelset(scenario.wheelset), load_track(scenario.track)
    dx = scenario.step_length
    bay = track.spacing / dx
    if not _whole(bay):
        raise InputError(
            f"step_length = {dx:g} m does not divide the sleeper spacing of {track.spacing:g} m: "
            f"give {_dividing(track.spacing, math.ceil(bay))} m"
        )
    if track.line is not None and scenario.dynamics == "paper":
        raise InputError("track.line cannot be followed in paper dynamics, whose supports are all the same: use causal")
    geometry = contact_geometry(scenario, wheelset)
    if isinstance(wheelset, Wheelset):
        shifts = geometry.touch(0) - geometry.rolling_circle(0), geometry.touch(1) - geometry.rolling_circle(1)
        wheelset = replace(wheelset, contact_shifts=shifts)
    return wheelset, track, geometry


def _whole(count: float) -> bool:
    return abs(count - round(count)) <= 1e-6


def _dividing(length: float, parts: int) -> str:
    """A length that goes ``parts`` times into ``length``, or a little more often: the first that few digits can say."""
    told = (f"{length / count:.6g}" for count in range(parts, 2 * parts + 1))
    return next((each for each in told if _whole(length / float(each))), f"{length / parts!r}")


def load_models(
    scenario: Scenario, progress: Progress | None = None, *, tables: bool | Literal["smooth"] = True
) -> Models:
    """Models of a scenario, ``tables`` as for ``build_contact_law``; raises InputError for what cannot be used."""
    if scenario.dynamics == "paper":
        return _models(scenario, progress, tables)
    with compiled_meanwhile(KERNELS):
        models = _models(scenario, progress, tables)
        models.contact_law((), progress)
    return models


def _models(scenario: Scenario, progress: Progress | None, tables: bool | Literal["smooth"]) -> Models:
    wheelset, track, geometry = described(scenario)
    dx = scenario.step_length
    reduced = reduce_wheelset(wheelset, progress)
    nodes, band, lag_zero = scenario.output.stress_nodes, scenario.max_frequency, scenario.at_lag_zero
    dynamics: DynamicsModel
    if scenario.dynamics == "paper":
        dynamics = paper_model(reduced, track, nodes, max_frequency=band, lag_zero=lag_zero, progress=progress)
    else:
        kept = reduced if band is None else truncated(reduced, band)
        if track.line is not None:
            dynamics = line_model(running_wheelset(kept, nodes, lag_zero), track_line(track), dx, lag_zero)
        else:
            limit = min(band or MAX_FREQUENCY, MAX_FREQUENCY)
            running = moving_track(track, dx, max_frequency=limit, progress=progress)
            dynamics = causal_model(kept, running, nodes, lag_zero)
    return Models(
        wheelset=wheelset,
        reduced=reduced,
        track=track,
        dynamics=dynamics,
        geometry=geometry,
        step_length=dx,
        steps_per_revolution=round(2 * math.pi * reduced.rolling_radius / dx),
        tread_origin=round(scenario.reference_position / dx),
        tables=tables,
    )
