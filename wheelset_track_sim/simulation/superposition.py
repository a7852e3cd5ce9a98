"""Stresses of loads beside the contact forces, added to what the contact forces make of the axle.

Press fit, own weight, lateral forces and given stresses are constant. Torque, with the longitudinal forces of the rails
that react to it, is followed without delay: its stress is static at each instant, which holds while it changes slowly
against the first twisting mode of the wheelset: 91 Hz of the X40.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ..runtime.arrays import Real
from ..runtime.one_core import one_core
from ..scenario.loads import Loads
from ..wheelset.around import Around, angles_of
from ..wheelset.imported import ImportedWheelset
from ..wheelset.kinds import AnyWheelset, with_geometry
from ..wheelset.reduced import ReducedWheelset
from ..wheelset.static_bending import lateral_stress, longitudinal_stress, own_weight_stress
from ..wheelset.static_loads import press_fit_stress, reacted, torsion_stress


@dataclass(frozen=True)
class TorqueCourse:
    """Torque over time: linear between points, constant before the first and after the last one."""

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
    """What is added to the stress of N nodes, and around the axle at their places."""

    constant: Around
    """Pa. Given stresses turn with the axle, as press fit does: they are the same all around."""
    of_torque: Around
    """Pa for each N m of torque."""
    angles: Real
    """(N,) rad of the nodes, from the top."""
    torque: TorqueCourse

    @cached_property
    def _at_nodes(self) -> tuple[Real, Real]:
        """What is constant, and what comes for each N m, (6 N, 1) in x, y, z."""
        return self.constant.at(self.angles).reshape(-1, 1), self.of_torque.at(self.angles).reshape(-1, 1)

    def stresses(self, times: Real) -> Real:
        """What is added at the nodes at ``times`` (n,) s since step 0: (6 N, n) Pa."""
        constant, of_torque = self._at_nodes
        added: Real = constant + of_torque * self.torque.at(times)
        return added


def superposition(
    loads: Loads, wheelset: AnyWheelset, reduced: ReducedWheelset, nodes: Sequence[str]
) -> Superposition | None:
    """What ``loads``, which fit the wheelset, add at stress nodes; None if they are none."""
    if loads.none:
        return None
    angles = angles_of(reduced.node_positions)
    given = np.zeros((len(angles), 6))
    for item in loads.stresses:
        given[reduced.node(item.node)] += item.components
    constant = _press_fit(wheelset, reduced, loads.press_fit.wheels, loads.press_fit.equipment)
    constant += Around.of_points(given, angles)
    if loads.own_weight:
        constant += _own_weight(wheelset, reduced)
    if any(loads.lateral.forces):
        constant += _lateral(wheelset, reduced, loads.lateral.forces)
    of_torque = Around.none(len(angles))
    if loads.with_torque:
        of_torque = _torsion(wheelset, reduced, loads.torque_at, loads.wheel_1_share)
        if loads.horizontal_bending:
            of_torque += _longitudinal(wheelset, reduced, loads.wheel_1_share)
    plan = [(point.time, point.torque) for point in loads.torque_plan] or [(0.0, loads.torque)]
    course = TorqueCourse(tuple(time for time, _ in plan), tuple(torque for _, torque in plan))
    chosen = [reduced.node(name) for name in nodes]
    return Superposition(constant.chosen(chosen), of_torque.chosen(chosen), angles[chosen], course)


def followed(
    before: Superposition | None, after: Superposition | None, time: float, loads: Loads
) -> Superposition | None:
    """What is superposed from ``time`` on, s, when ``loads`` take effect: their torque is approached.

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
def _press_fit(wheelset: AnyWheelset, reduced: ReducedWheelset, wheels: float, equipment: float) -> Around:
    """Stress at all nodes of a wheelset."""
    if not (wheels or equipment):
        return Around.none(len(reduced.node_names))
    with one_core():
        return press_fit_stress(with_geometry(wheelset), reduced.node_positions[:, 1], wheels, equipment)


@lru_cache(maxsize=8)
def _own_weight(wheelset: AnyWheelset, reduced: ReducedWheelset) -> Around:
    """Stress at all nodes."""
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.under_own_weight()
    with one_core():
        return own_weight_stress(wheelset, reduced.node_positions[:, 1])


@lru_cache(maxsize=8)
def _lateral(wheelset: AnyWheelset, reduced: ReducedWheelset, forces: tuple[float, float]) -> Around:
    """Stress at all nodes."""
    with one_core():
        return lateral_stress(with_geometry(wheelset), reduced.node_positions[:, 1], np.array(forces))


@lru_cache(maxsize=8)
def _torsion(
    wheelset: AnyWheelset, reduced: ReducedWheelset, torque_at: tuple[str, ...], wheel_1_share: float
) -> Around:
    """Stress at all nodes for each N m of torque."""
    if isinstance(wheelset, ImportedWheelset):
        return wheelset.torsion(reacted(torque_at, wheel_1_share))
    with one_core():
        return torsion_stress(wheelset, reduced.node_positions[:, 1], reacted(torque_at, wheel_1_share))


@lru_cache(maxsize=8)
def _longitudinal(wheelset: AnyWheelset, reduced: ReducedWheelset, wheel_1_share: float) -> Around:
    """Stress at all nodes for each N m of torque, by the rails' longitudinal forces."""
    with one_core():
        return longitudinal_stress(with_geometry(wheelset), reduced.node_positions[:, 1], wheel_1_share)
