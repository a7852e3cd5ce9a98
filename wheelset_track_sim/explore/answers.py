"""Answers to views: one turn of the wheel over the rail, and the contact at a moment of it."""

from __future__ import annotations

import dataclasses
import math
import time
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from ..contact.solutions import ContactPatch
from ..fatigue.static_stress import AXIAL, StaticStress, static_stress
from ..runtime.arrays import Real
from ..runtime.progress import Progress, unreported
from ..samples.block import SampleBlock
from ..scenario import WHEELS, Scenario
from ..simulation.instants import Contact
from ..simulation.models import Models, load_models
from ..simulation.passages import Passages
from ..simulation.simulator import Simulator
from .view import Base, View

POINTS = 72
"""Points around the axle of which the worst one is shown: the range is within 0.1 %."""
BEFORE = 0.9
"""Track before the place where angle 0 of the treads meets the rail, m; the rest of a turn is behind it."""
KEPT_MODELS, KEPT_SURFACES = 3, 2
"""Models, and surfaces to settle on, that are kept: the latest. A surface has 16 runs of 12 MB, by speed and load."""
SHOWN = 0.080
"""Track ahead of and behind the middle of the contact that is drawn, m."""

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Answer:
    """One turn of the wheel under the conditions of a view."""

    view: View
    scenario: Scenario
    block: SampleBlock
    run: Simulator
    nodes: tuple[str, ...]
    fixed: Real
    """Axial stress at the top of the axle, which does not turn, (samples, nodes), Pa."""
    turning: Real
    """Axial stress of the point around the axle that has the largest range over the turn, (samples, nodes), Pa."""
    undamaged: Real
    """Amplitude of rotating bending under the static load, (nodes,), Pa."""
    seconds: float
    """How long it took."""

    @property
    def position(self) -> Real:
        """Of each sample along the track from the sleeper at or before angle 0 of the treads, (samples,), m."""
        scenario = self.scenario
        steps = self.block.first_step + np.arange(len(self.block))
        bay = scenario.track.spacing
        origin = math.floor(scenario.reference_position / bay + 1e-6) * bay
        position: Real = steps * np.float64(scenario.step_length) - origin
        return position

    @property
    def wheel(self) -> int:
        """The damaged wheel, 0 or 1."""
        return WHEELS.index(self.view.on)

    @property
    def peak_row(self) -> int:
        """Sample with the largest force of the damaged wheel."""
        return int(self.block.forces[:, self.wheel].argmax())

    @property
    def amplitude(self) -> Real:
        """Half the range of the turning points over the turn, (nodes,), Pa."""
        found: Real = np.ptp(self.turning, axis=0) / 2
        return found

    @property
    def contact_loss(self) -> Real:
        """Time without contact, (2,), s."""
        found: Real = (self.block.forces <= 0.0).sum(axis=0) * self.block.step_period
        return found

    def moment(self, row: int) -> Moment:
        """Contact of the damaged wheel at a sample; ContactError if it has no solution."""
        contact = self.run.contact(self.wheel, min(max(row, 0), len(self.block) - 1))
        return Moment(contact, contact.solve(), self.scenario.wheelset.rolling_radius)


@dataclass(frozen=True, eq=False)
class Moment:
    """A solved contact, and the bodies around it."""

    contact: Contact
    patch: ContactPatch
    radius: float
    """Of the wheel, m."""

    def profiles(self) -> tuple[Real, Real, Real]:
        """Positions ahead of the contact, the heights of the rail, and those of the wheel above it, (n,) each, m.

        They are those of the line along the track in which the pressure is largest. Where the bodies press on each
        other, the wheel has the height of the rail.
        """
        contact, law = self.contact, self.contact.law
        dx = float(law.x[1] - law.x[0])
        reach = round(SHOWN / dx)
        steps = np.arange(-reach, reach + 1)
        line = int(self.patch.pressure.max(axis=0).argmax()) if self.patch.force > 0 else law.y.shape[1] // 2
        tread = law.tread[contact.wheel, (contact.tread_step + steps) % law.tread.shape[1], line]
        row = law.rail_row[contact.wheel]
        rail = law.rail[row[(contact.step + steps) % len(row)], line]
        x: Real = steps * np.float64(dx)
        nominal = x**2 / (self.radius + np.sqrt(self.radius**2 - x**2))
        nominal += law.separation[contact.wheel, len(law.x) // 2, line]
        gap = nominal - tread - rail - contact.approach
        return x, rail, rail + np.maximum(gap, 0.0)

    @property
    def gap(self) -> float:
        """Smallest distance of the bodies in that line, m; 0 in contact."""
        _, rail, wheel = self.profiles()
        return float((wheel - rail).min())


class Explorer:
    """Answers views of one scenario; models and settled runs are kept. For one thread."""

    def __init__(self, base: Base) -> None:
        self.base = base
        self._models: OrderedDict[Any, Models] = OrderedDict()
        self._tabled: OrderedDict[Any, Models] = OrderedDict()
        self._passages: OrderedDict[Any, Passages] = OrderedDict()

    def answer(self, view: View, progress: Progress = unreported) -> Answer:
        """Answer of a view.

        ``progress`` is called while models are built; what it raises ends the work. Raises InputError for values that
        do not fit each other, ContactError for a contact without solution.
        """
        began = time.perf_counter()
        around = self.base.surroundings(view)
        damage = self.base.damage(view, around)
        passages = self._settled(around, progress)
        static = static_stress(around, self.models(around).reduced, around.output.stress_nodes)
        run, block = passages.follow(damage, speed=view.speed, axle_load=view.load)
        fixed = block.stresses[:, [block.nodes.index(name) for name in static.nodes], AXIAL]
        bending = static.bending_of(fixed)
        turning = _turning(bending, static, around)
        undamaged = static.amplitude
        return Answer(
            *(view, run.scenario, block, run, static.nodes, fixed, turning, undamaged),
            time.perf_counter() - began,
        )

    def models(self, scenario: Scenario, progress: Progress = unreported) -> Models:
        """Models of a scenario."""
        return _kept(
            self._models,
            (scenario.wheelset.name, scenario.track.name),
            KEPT_MODELS,
            lambda: load_models(scenario, progress, tables="smooth"),
        )

    def tabled(self, scenario: Scenario, progress: Progress = unreported) -> Models:
        """The same with force tables, for long runs."""
        key = scenario.wheelset.name, scenario.track.name

        def made() -> Models:
            return dataclasses.replace(self.models(scenario, progress), tables=True, _smooth=None, _preloads={})

        return _kept(self._tabled, key, KEPT_MODELS, made)

    def _settled(self, scenario: Scenario, progress: Progress) -> Passages:
        """Passages on the surfaces of a scenario; speed and load are given to each of them."""

        def made() -> Passages:
            models = self.models(scenario, progress)
            before = min(BEFORE, scenario.reference_position)
            after = (scenario.steps_per_revolution - 1) * scenario.step_length - before
            return Passages(scenario, models=models, before=before, after=after)

        key = scenario.wheelset.name, scenario.track.name, scenario.irregularities
        return _kept(self._passages, key, KEPT_SURFACES, made)


def _turning(bending: Real, static: StaticStress, scenario: Scenario) -> Real:
    """Stress of the point around each node that has the largest range, (samples, nodes), Pa."""
    turned = 2 * np.pi * np.arange(len(bending)) / scenario.steps_per_revolution
    angles = turned + 2 * np.pi * np.arange(POINTS)[:, np.newaxis] / POINTS
    cosines, sines = np.cos(angles), np.sin(angles)
    found = np.empty_like(bending)
    for node, mean in enumerate(static.mean):
        points = mean + cosines * bending[:, node] + sines * static.sideways[node]
        found[:, node] = points[np.ptp(points, axis=1).argmax()]
    return found


def _kept(kept: OrderedDict[Any, T], key: Any, most: int, make: Any) -> T:
    """What is kept under a key, made if it is not; the latest ``most`` stay."""
    found = kept.pop(key) if key in kept else make()
    kept[key] = found
    while len(kept) > most:
        kept.popitem(last=False)
    return found
