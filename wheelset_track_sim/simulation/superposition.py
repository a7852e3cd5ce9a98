"""Stresses of loads beside the contact forces, added to what the contact forces make of the axle.

Press fit and given stresses are constant. Torque is followed without delay: its stress is that of static torsion at
each instant, which holds while it changes slowly against the first twisting mode of the wheelset: 91 Hz of the X40.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..runtime.arrays import Real
from ..runtime.one_core import one_core
from ..scenario.loads import Loads
from ..wheelset.imported import ImportedWheelset
from ..wheelset.kinds import AnyWheelset, with_geometry
from ..wheelset.reduced import ReducedWheelset
from ..wheelset.static_loads import press_fit_stress, reacted, torsion_stress


@dataclass(frozen=True)
class TorqueCourse:
    """Torque over time: linear between points, constant before the first and behind the last one."""

    times: tuple[float, ...]
    """s since step 0."""
    torques: tuple[float, ...]
    """N m."""

    def at(self, times: Real) -> Real:
        """Torque at ``times`` (n,) s: (n,) N m."""
        return np.interp(times, self.times, self.torques)

    def approaching(self, time: float, torque: float, rate: float) -> TorqueCourse:
        """From ``time`` on to another torque, N m, at ``rate``, N m/s, from the one that is in force there."""
        now = float(self.at(np.array([time]))[0])
        if now == torque:
            return TorqueCourse((time,), (torque,))
        return TorqueCourse((time, time + abs(torque - now) / rate), (now, torque))


UNLOADED = TorqueCourse((0.0,), (0.0,))


@dataclass(frozen=True, eq=False)
class Superposition:
    """What is added to the stress components of N nodes, (N, 6) flattened."""

    constant: Real
    """(6 N,) Pa."""
    torsion: Real
    """(6 N,) Pa for each N m of torque."""
    torque: TorqueCourse

    def stresses(self, times: Real) -> Real:
        """What is added at ``times`` (n,) s since step 0: (6 N, n) Pa."""
        added: Real = self.constant[:, np.newaxis] + np.outer(self.torsion, self.torque.at(times))
        return added


def superposition(
    loads: Loads, wheelset: AnyWheelset, reduced: ReducedWheelset, nodes: Sequence[str]
) -> Superposition | None:
    """What ``loads``, which fit the wheelset, add at stress nodes; None if they are none."""
    if loads.none:
        return None
    constant = _press_fit(wheelset, reduced, loads.press_fit.wheels, loads.press_fit.equipment).copy()
    for item in loads.stresses:
        constant[reduced.node(item.node)] += item.components
    torsion = np.zeros_like(constant)
    if loads.with_torque:
        torsion = _torsion(wheelset, reduced, loads.torque_at, loads.wheel_1_share)
    plan = [(point.time, point.torque) for point in loads.torque_plan] or [(0.0, loads.torque)]
    course = TorqueCourse(tuple(time for time, _ in plan), tuple(torque for _, torque in plan))
    chosen = [reduced.node(name) for name in nodes]
    return Superposition(constant[chosen].ravel(), torsion[chosen].ravel(), course)


def followed(
    before: Superposition | None, after: Superposition | None, time: float, loads: Loads
) -> Superposition | None:
    """What is superposed from ``time`` on, s, when ``loads`` come into force: their torque is approached.

    ``before`` is what has been superposed, ``after`` what the new loads superpose alone; a plan that stays goes on.
    """
    if before is not None and loads.torque_plan:
        return before
    base = after if loads.with_torque or before is None else before  # a torque that goes to zero has to get there
    if base is None:
        return None
    now = before.torque if before else UNLOADED
    return replace(base, torque=now.approaching(time, loads.torque, loads.torque_rate))


@lru_cache(maxsize=8)
def _press_fit(wheelset: AnyWheelset, reduced: ReducedWheelset, wheels: float, equipment: float) -> Real:
    """Stress (N, 6) at all nodes of a wheelset."""
    if not (wheels or equipment):
        return np.zeros((len(reduced.node_names), 6))
    with one_core():
        return press_fit_stress(with_geometry(wheelset), reduced.node_positions, wheels, equipment)


@lru_cache(maxsize=8)
def _torsion(wheelset: AnyWheelset, reduced: ReducedWheelset, torque_at: tuple[str, ...], wheel_1_share: float) -> Real:
    """Stress (N, 6) at all nodes for each N m of torque."""
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.torsion(reacted(torque_at, wheel_1_share))
    with one_core():
        return torsion_stress(wheelset, reduced.node_positions, reacted(torque_at, wheel_1_share))
