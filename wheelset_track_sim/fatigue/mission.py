"""Missions: the speeds, loads and growing damage of an axle's service, and the damage that they add up to.

A mission has legs, which share every kilometre, and stages of damage, which follow one another over the distance. Each
leg is simulated at each stage over a sample of distance, which gives a damage a metre at each point of the axle, d.
After the distance s, with the shares w and the length l of a stage that has been run by then::

    D(s) = sum over stages l(s) sum over legs w d

Each turn is a cycle of rotating bending, so the few cycles from leg to leg are neglected.
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..inputs import shipped
from ..inputs.schema import check, confirmed_numbers, keyed, quantity, read
from ..runtime.arrays import Real
from ..scenario import Scenario, assign, scenario_from, suspect, take_in
from .axle import NodeFatigue

ROUNDING = 1e-6
"""By which the shares of all legs may differ from 1."""


@dataclass(frozen=True)
class Leg:
    """A part of every kilometre."""

    share: float = quantity("", 1e-6, 1.0, "the share of the distance")
    name: str = ""
    speed: float | None = quantity("m/s", 5.0, 100.0, "the running speed", default=None, usual=(5.0, 100.0))
    axle_load: float | None = quantity("N", 2e4, 4e5, "the static load on both wheels together", default=None)
    set: Any = field(default_factory=dict)
    """Dotted scenario keys with their values."""

    def __post_init__(self) -> None:
        check(self)
        keyed(self.set, "set")

    @property
    def changes(self) -> dict[str, Any]:
        """All keys in which it differs from the scenario."""
        given = {"speed": self.speed, "axle_load": self.axle_load}
        return {**{key: value for key, value in given.items() if value is not None}, **self.set}


@dataclass(frozen=True)
class Stage:
    """Damage from a distance on, until the next stage."""

    after: float = quantity("m", 0.0, 1e10, "the distance at which the stage begins")
    set: Any = field(default_factory=dict)
    """Dotted scenario keys with their values."""

    def __post_init__(self) -> None:
        check(self)
        keyed(self.set, "set")


@dataclass(frozen=True)
class Mission:
    """Service of an axle.

    Examples
    --------
    >>> [leg.share for leg in load_mission("intercity").legs]
    [0.3, 0.5, 0.2]
    """

    title: str
    legs: tuple[Leg, ...]
    growth: tuple[Stage, ...] = (Stage(0.0),)
    sample: float = quantity("m", 10.0, 1e5, "the distance that is simulated of each leg and stage", default=500.0)

    def __post_init__(self) -> None:
        check(self)
        if not self.legs or not self.growth:
            raise InputError("legs or growth is empty: give at least one leg, and leave growth out if nothing grows")
        shares = math.fsum(leg.share for leg in self.legs)
        if abs(shares - 1) > ROUNDING:
            raise InputError(f"legs have shares of {shares:g} in all: give shares that add up to 1")
        if self.growth[0].after != 0:
            raise InputError(f"growth.0.after = {self.growth[0].after:g} m: begin with a stage after 0 m")
        for number, (before, stage) in enumerate(itertools.pairwise(self.growth), 1):
            if stage.after <= before.after:
                raise InputError(
                    f"growth.{number}.after = {stage.after:g} m is not beyond the stage before, {before.after:g} m: "
                    "give increasing distances"
                )

    def label(self, leg: int, stage: int) -> str:
        """Name of a leg at a stage for people."""
        name = self.legs[leg].name or f"leg {leg + 1}"
        return f"{name}, stage {stage + 1}" if len(self.growth) > 1 else name

    def scenarios(self, base: Scenario) -> list[list[Scenario]]:
        """Scenario of each stage and leg; raises InputError for one that cannot be used."""
        if base.speed_plan or base.events:
            raise InputError(
                "the scenario has a speed_plan or events, and a mission has its own speeds and damage: leave them out"
            )
        plain = base.to_mapping()
        return [
            [self._scenario(plain, leg, stage) for leg in range(len(self.legs))] for stage in range(len(self.growth))
        ]

    def _scenario(self, base: Mapping[str, Any], leg: int, stage: int) -> Scenario:
        data = copy.deepcopy(dict(base))
        for where, changes in (
            (f"growth.{stage}.set", self.growth[stage].set),
            (f"legs.{leg}", self.legs[leg].changes),
        ):
            for key, value in changes.items():
                suspect(key, value, f"{where}.{key}")
                assign(data, key, copy.deepcopy(value), f"{where}: ")
        try:
            take_in(data)
            with confirmed_numbers():
                return scenario_from(data)
        except InputError as refusal:
            raise InputError(f"{refusal} ({self.label(leg, stage)})") from None

    def lengths(self, distance: float) -> list[float]:
        """Distance that is run at each stage of the first ``distance``, m."""
        ends = [*(stage.after for stage in self.growth[1:]), math.inf]
        return [max(min(end, distance) - stage.after, 0.0) for stage, end in zip(self.growth, ends, strict=True)]


def load_mission(source: str | Path) -> Mission:
    """Load a mission.

    Parameters
    ----------
    source
        Name of a shipped mission (``intercity``), or path of a YAML file.

    Returns
    -------
    Mission
        Legs, stages and their changes.

    Raises
    ------
    InputError
        In one line, for a name, key or value that cannot be used.
    """
    return read(Mission, shipped.load_yaml("missions", source), "")


@dataclass(frozen=True, eq=False)
class MissionNode:
    """Damage of a mission at a stress node."""

    name: str
    starts: Real
    """(S,) distances at which stages begin, m."""
    rates: Real
    """(S, K, rules): damage a metre at each stage, 1/m."""
    undamaged_rates: Real
    """(S, rules): likewise under the static loads, 1/m."""
    leg_rates: Real
    """(S, legs, K): share of each leg in the elementary ``rates``, 1/m."""
    amplitude: float
    """Largest of all legs and stages, Pa."""
    angles: Real
    """(K,) rad."""

    def damage(self, distance: float) -> Real:
        """Damage after a distance, m, (K, rules)."""
        found: Real = np.tensordot(self._lengths(distance), self.rates, 1)
        return found

    def undamaged(self, distance: float) -> Real:
        """Damage without damaged wheels after a distance, m, (rules,)."""
        found: Real = self._lengths(distance) @ self.undamaged_rates
        return found

    def worst(self, distance: float) -> int:
        """Number of the point with most damage by the elementary rule after a distance, m."""
        return int(np.argmax(self.damage(distance)[:, 0]))

    def leg_shares(self, distance: float) -> Real:
        """Share of each leg in the damage at the worst point after a distance, m, (legs,)."""
        by_leg = np.tensordot(self._lengths(distance), self.leg_rates, 1)[:, self.worst(distance)]
        found: Real = by_leg / by_leg.sum()
        return found

    def life(self, damage: float = 1.0) -> Real:
        """Distance at which the first point reaches a ``damage``, m, by rule (rules,); infinite where none does."""
        before = np.zeros(self.rates.shape[1:])
        found = np.full(self.rates.shape[2], np.inf)
        for number, start in enumerate(self.starts):
            rate = self.rates[number]
            with np.errstate(divide="ignore", invalid="ignore"):
                reached = np.where(rate > 0, start + (damage - before) / rate, np.inf).min(axis=0)
            end = self.starts[number + 1] if number + 1 < len(self.starts) else np.inf
            found = np.where(np.isinf(found) & (reached <= end), reached, found)
            if np.isfinite(end):
                before = before + rate * (end - start)
        return found

    def _lengths(self, distance: float) -> Real:
        return np.clip(distance - self.starts, 0.0, np.diff([*self.starts, np.inf]))


def mission_damage(mission: Mission, found: Sequence[Sequence[Sequence[NodeFatigue]]]) -> tuple[MissionNode, ...]:
    """Damage of a mission from that of its samples.

    Parameters
    ----------
    mission
        With S stages and L legs.
    found
        Nodes of each stage and leg; all have the same names and angles.

    Returns
    -------
    tuple of MissionNode
        One for each stress node.
    """
    shares = np.array([leg.share for leg in mission.legs])
    nodes = []
    for number, first in enumerate(found[0][0]):
        samples = [[leg[number] for leg in stage] for stage in found]
        rates = np.array([[node.damage / node.distance for node in stage] for stage in samples])
        without = np.array([[node.undamaged / node.distance for node in stage] for stage in samples])
        nodes.append(
            MissionNode(
                name=first.name,
                starts=np.array([stage.after for stage in mission.growth]),
                rates=np.einsum("l,slkr->skr", shares, rates),
                undamaged_rates=np.einsum("l,slr->sr", shares, without),
                leg_rates=shares[:, np.newaxis] * rates[..., 0],
                amplitude=max(node.amplitude for stage in samples for node in stage),
                angles=first.angles,
            )
        )
    return tuple(nodes)
