"""Fatigue of a turning axle: stress of material points around each stress node, counted, with damage by distance.

A stress node does not turn. A point of the axle's surface that is at the angle phi from the top when angle 0 of the
treads meets the rail sees the bending b(t) of the node, and not more, as it turns::

    sigma(t) = m + b(t) cos(theta(t) + phi) + h sin(theta(t) + phi)

``static_stress`` has m and h. The blocks hold stresses at one angle of each node, so all of b is taken as the first
harmonic around the axle. Turning strain gauges, which have the harmonics 0 to 6, agree: on the axle's body of the X40
with a 2 mm breakout the even harmonics have at most 0.3 MPa, and the damage at an angle differs by up to 1.4 %.

Without damage, b is that of the static load but for the bays, and each turn is one cycle of the amplitude
S = sqrt(b^2 + h^2). So the damage of a distance s is in closed form, with the wheel's circumference c::

    D = s / (c N(S, m))
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..runtime.arrays import Real
from ..samples.block import SampleBlock
from ..scenario import Scenario
from .curve import Curve
from .rainflow import GATE, Rainflow, StressSpectrum
from .rainflow_kernels import damage_of, equivalent_amplitude
from .static_stress import AXIAL, StaticStress
from .turning_kernels import count_turning

POINTS = 36
"""Points around the axle by default."""
MOST_POINTS = 720
MOST_MARKS = 128
"""Marks of distance at most; if there are more, every second one is left out."""


@dataclass(frozen=True)
class TurningWheel:
    """How a wheel turns over the steps of a run."""

    turn: int
    """Steps of a turn."""
    origin: int
    """Step at which angle 0 of the treads meets the rail."""
    step_length: float
    """m"""

    @classmethod
    def of(cls, scenario: Scenario) -> TurningWheel:
        """Of a scenario."""
        return cls(scenario.steps_per_revolution, scenario.tread_origin, scenario.step_length)

    @property
    def circumference(self) -> float:
        """Distance of a turn, m."""
        return self.turn * self.step_length


@dataclass(frozen=True, eq=False)
class NodeFatigue:
    """Fatigue at a stress node over a distance. Damage is by rule, in the order of ``Curve.rules``."""

    name: str
    distance: float
    """m"""
    amplitude: float
    """Largest half range that a point goes through in a turn, Pa."""
    mean: float
    """Constant part of the stress, Pa."""
    undamaged_amplitude: float
    """Half range of a turn under the static load, Pa."""
    angles: Real
    """(K,) phi of the points from the mark of the axle, rad."""
    damage: Real
    """(K, rules) over the distance."""
    undamaged: Real
    """(rules,) over the distance under the static load, in closed form."""
    equivalent_range: float
    """Range of one cycle a turn at mean stress 0 that damages as much by the elementary rule at the worst angle, Pa."""

    @property
    def worst(self) -> int:
        """Number of the point with most damage by the elementary rule."""
        return int(np.argmax(self.damage[:, 0]))

    @property
    def angle(self) -> float:
        """Phi of that point from the mark of the axle, rad."""
        return float(self.angles[self.worst])

    @property
    def ratios(self) -> tuple[float, ...]:
        """Damage at the worst angle over that without damage, by rule; NaN where there is none without."""
        pairs = zip(self.damage[self.worst], self.undamaged, strict=True)
        return tuple(float(found / without) if without > 0 else math.nan for found, without in pairs)

    def damage_in(self, distance: float) -> tuple[float, ...]:
        """Damage at the worst angle by rule, scaled to a distance, m."""
        return tuple((self.damage[self.worst] * (distance / self.distance)).tolist())


def equivalent_range(damage: float, curve: Curve) -> float:
    """Range of one cycle a turn at mean stress 0, Pa, that does a ``damage`` a turn by the elementary rule."""
    return float(2 * curve.limit * (damage * curve.knee_cycles) ** (1 / curve.slope))


class AxleFatigue:
    """Counts the stress of the points of a turning axle in gap-free blocks at full rate, however they are cut.

    Examples
    --------
    >>> simulator = Simulator(scenario := load_scenario("damage_wheel_1"))
    >>> static = static_stress(scenario, simulator.models.reduced, scenario.output.stress_nodes)
    >>> fatigue = AxleFatigue(static, TurningWheel.of(scenario), load_curve("assumed_body"))
    >>> fatigue.push(simulator.advance(5 * simulator.steps_per_revolution))
    >>> a1, *_ = fatigue.nodes
    """

    def __init__(
        self,
        static: StaticStress,
        wheel: TurningWheel,
        curve: Curve,
        *,
        points: int = POINTS,
        gate: float = GATE,
        mark: float = 0.0,
    ) -> None:
        """Count at a number of points around each node of ``static``; ranges up to the gate, Pa, are merged.

        The first point is at the ``mark`` of the axle: its angle phi from the top when angle 0 of the treads meets the
        rail, rad.
        """
        if not 4 <= points <= MOST_POINTS:
            raise InputError(f"angles = {points} is out of range: give 4 to {MOST_POINTS} points around the axle")
        self.static, self.wheel, self.curve, self.gate = static, wheel, curve, gate
        self.angles = 2 * np.pi * np.arange(points) / points
        self.steps = 0
        turned = 2 * np.pi * ((np.arange(wheel.turn) - wheel.origin) % wheel.turn) / wheel.turn
        around = turned + (self.angles + mark)[:, np.newaxis]
        self._cosines, self._sines = np.cos(around), np.sin(around)
        self._count = Rainflow(len(static.nodes) * points, curve, gate)
        self._next: int | None = None
        self._every = 1
        self._marks: list[tuple[int, int, Real]] = []
        self._low = np.full((len(static.nodes), points), np.inf)
        self._high, self._amplitude = -self._low, np.zeros(len(static.nodes))

    def push(self, block: SampleBlock) -> None:
        """Take in the next steps; raises InputError if steps are missing or decimated."""
        if block.decimation != 1:
            raise InputError(f"every {block.decimation}th step is no stress history: give samples at full rate")
        if self._next is not None and block.first_step != self._next:
            raise InputError(f"steps {self._next} to {block.first_step} are missing: give blocks without gaps")
        columns = [block.nodes.index(name) for name in self.static.nodes]
        bending = np.ascontiguousarray(self.static.bending_of(block.stresses[:, columns, AXIAL]).T)
        row = 0
        while row < len(block):
            step = (block.first_step + row) % self.wheel.turn
            part = bending[:, row : row + self.wheel.turn - step]
            self._push(part, step)
            row += part.shape[1]
            if step + part.shape[1] == self.wheel.turn:
                self._mark((block.first_step + row) // self.wheel.turn, self.steps + row)
        self._next = block.first_step + len(block)
        self.steps += len(block)

    def _push(self, bending: Real, step: int) -> None:
        """Take in steps of one turn, (nodes, n), from ``step`` of it on."""
        end = step + bending.shape[1]
        static, count = self.static, self._count
        count_turning(
            count.state,
            np.ascontiguousarray(bending),
            static.sideways,
            static.mean,
            np.ascontiguousarray(self._cosines[:, step:end]),
            np.ascontiguousarray(self._sines[:, step:end]),
            self._low,
            self._high,
            count.gate,
            count.sensitivity,
            count.curve.constants,
        )
        if end == self.wheel.turn:
            self._amplitude = self._amplitudes
            self._low[:], self._high[:] = np.inf, -np.inf

    def _mark(self, turn: int, steps: int) -> None:
        """Keep the damage at the end of a turn, after so many steps."""
        if turn % self._every == 0:
            self._marks.append((turn, steps, self._count.damage))
        if len(self._marks) > MOST_MARKS:
            self._every *= 2
            self._marks = [mark for mark in self._marks if mark[0] % self._every == 0]

    @property
    def damage(self) -> Real:
        """Damage so far, (nodes, K, rules)."""
        return self._count.damage.reshape(len(self.static.nodes), len(self.angles), -1)

    @property
    def marks(self) -> tuple[Real, Real]:
        """Distances at the ends of turns, (M,) m, and the damage up to there, (M, nodes, K, rules).

        They are the same however a run is cut; a long run has marks farther apart.
        """
        distances = np.array([steps for _, steps, _ in self._marks], dtype=np.float64) * self.wheel.step_length
        shape = (len(self._marks), len(self.static.nodes), len(self.angles), len(self.curve.rules))
        return distances, np.array([damage for *_, damage in self._marks], dtype=np.float64).reshape(shape)

    @property
    def next_step(self) -> int | None:
        """Step with which the next block begins; None before the first one."""
        return self._next

    @property
    def _amplitudes(self) -> Real:
        """Largest of the turns so far, the one that has begun included, (nodes,), Pa."""
        found: Real = np.maximum(self._amplitude, (self._high - self._low).max(axis=1) / 2)
        return found

    @property
    def spectrum(self) -> StressSpectrum:
        """Cycles so far of all points, those of the first node first."""
        return self._count.spectrum

    @property
    def nodes(self) -> tuple[NodeFatigue, ...]:
        """Fatigue of each node so far, the residue counted as half cycles."""
        static, curve = self.static, self.curve
        distance = self.steps * self.wheel.step_length
        turns = self.steps / self.wheel.turn
        amplitude = self._amplitudes
        found = []
        for node, (name, damage) in enumerate(zip(static.nodes, self.damage, strict=True)):
            mean, undamaged = float(static.mean[node]), float(static.amplitude[node])
            equivalent = equivalent_amplitude(undamaged, mean, curve.mean_stress_sensitivity)
            each = damage[:, 0].max() / turns if turns else 0.0
            found.append(
                NodeFatigue(
                    name=name,
                    distance=distance,
                    amplitude=float(amplitude[node]),
                    mean=mean,
                    undamaged_amplitude=undamaged,
                    angles=self.angles,
                    damage=damage,
                    undamaged=turns * np.array([damage_of(equivalent, rule) for rule in curve.constants]),
                    equivalent_range=equivalent_range(each, curve),
                )
            )
        return tuple(found)

    def saved(self) -> dict[str, NDArray[Any]]:
        """Arrays from which ``resume`` goes on, as ``numpy.savez`` takes them."""
        own = {"low": self._low, "high": self._high, "amplitude": self._amplitude}
        steps = np.array([self.steps, -1 if self._next is None else self._next])
        marks = {
            "marks": np.array([(turn, at) for turn, at, _ in self._marks], dtype=np.int64).reshape(-1, 2),
            "mark_damage": np.array([damage for *_, damage in self._marks]),
            "every": np.array(self._every),
        }
        return {**self._count.saved(), **{name: array.copy() for name, array in own.items()}, "steps": steps, **marks}

    def resume(self, saved: Mapping[str, NDArray[Any]]) -> None:
        """Go on from a saved state of the same nodes, points, curve and gate; raises InputError if shapes differ."""
        self._count.resume(saved)
        self._low, self._high, self._amplitude = (saved[name].copy() for name in ("low", "high", "amplitude"))
        self.steps, following = (int(each) for each in saved["steps"])
        self._next = None if following < 0 else following
        places = zip(saved["marks"].tolist(), saved["mark_damage"], strict=True)
        self._marks, self._every = [(turn, at, damage.copy()) for (turn, at), damage in places], int(saved["every"])
