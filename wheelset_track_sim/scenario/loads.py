"""Loads on the axle beside the contact forces: own weight, press fits, given stresses, torque and lateral forces.

They are superposed on the stress (Section 6 of the paper) and have no part in the vertical dynamics.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from itertools import pairwise

from ..errors import InputError
from ..inputs.schema import check, quantity, unknown
from ..wheelset.harmonics import GRAVITY
from ..wheelset.imported import ImportedWheelset
from ..wheelset.kinds import AnyWheelset, mass_of

STRESSES, FORCES, TORQUES = (1e5, 2e9), (1e3, 2e5), (50.0, 2e5)
"""Sizes that are not doubted when they are given without a unit, Pa, N and N m."""


@dataclass(frozen=True)
class PressFit:
    """Interference between the axle and what is pressed onto it: diameter of the seat less that of the bore."""

    wheels: float = quantity("m", 0.0, 1e-3, "the interference of the wheels", default=0.0)
    equipment: float = quantity("m", 0.0, 1e-3, "the interference of gearbox and rings", default=0.0)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class ConstantStress:
    """Stress that is always there at a node, such as one from another calculation."""

    node: str
    xx: float = quantity("Pa", -2e9, 2e9, "the constant stress xx", usual=STRESSES, default=0.0)
    yy: float = quantity("Pa", -2e9, 2e9, "the constant stress yy", usual=STRESSES, default=0.0)
    zz: float = quantity("Pa", -2e9, 2e9, "the constant stress zz", usual=STRESSES, default=0.0)
    xy: float = quantity("Pa", -2e9, 2e9, "the constant stress xy", usual=STRESSES, default=0.0)
    xz: float = quantity("Pa", -2e9, 2e9, "the constant stress xz", usual=STRESSES, default=0.0)
    yz: float = quantity("Pa", -2e9, 2e9, "the constant stress yz", usual=STRESSES, default=0.0)

    def __post_init__(self) -> None:
        check(self)

    @property
    def components(self) -> tuple[float, ...]:
        """xx, yy, zz, xy, xz, yz, Pa."""
        return self.xx, self.yy, self.zz, self.xy, self.xz, self.yz


@dataclass(frozen=True)
class LateralForces:
    """Constant lateral forces of the rails on the wheels at their contacts, to the left positive, as in a curve."""

    wheel_1: float = quantity("N", -2e5, 2e5, "the lateral force on wheel 1, to the left", usual=FORCES, default=0.0)
    wheel_2: float = quantity("N", -2e5, 2e5, "the lateral force on wheel 2, to the left", usual=FORCES, default=0.0)

    def __post_init__(self) -> None:
        check(self)

    @property
    def forces(self) -> tuple[float, float]:
        """On wheel 1 and 2, N."""
        return self.wheel_1, self.wheel_2


@dataclass(frozen=True)
class TorquePoint:
    """Torque at a time; between two of them it changes evenly."""

    time: float = quantity("s", 0.0, 1e6, "the time since the start")
    torque: float = quantity("N m", -2e5, 2e5, "the torque at that time", usual=TORQUES)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class Loads:
    """Own weight, press fits, given stresses, torque of drive or brake, lateral forces. SI units; none by default."""

    own_weight: bool = False
    """Whether the wheelset has its weight where its mass is: the journals then carry the axle load less that."""
    press_fit: PressFit = field(default_factory=PressFit)
    stresses: tuple[ConstantStress, ...] = ()
    torque: float = quantity("N m", -2e5, 2e5, "the torque on the wheelset", usual=TORQUES, default=0.0)
    """On all places together, about y: positive is traction, negative braking. Constant; changed during a run, the
    torque that is approached from then on."""
    torque_plan: tuple[TorquePoint, ...] = ()
    """The torque over time instead: that of the first point before it, of the last one after it."""
    torque_rate: float = quantity("N m/s", 1.0, 1e7, "the rate at which a changed torque is approached", default=2e4)
    torque_at: tuple[str, ...] = ("gearbox",)
    """Where it acts, in equal parts: ``gearbox``, equipment by name, ``wheel_1``, ``wheel_2``."""
    wheel_1_share: float = quantity("", 0.0, 1.0, "the share of the torque that rail 1 takes", default=0.5)
    horizontal_bending: bool = False
    """Whether the longitudinal forces by which the rails react to the torque bend the axle, held by the axle boxes."""
    lateral: LateralForces = field(default_factory=LateralForces)

    def __post_init__(self) -> None:
        check(self)
        for index, (before, after) in enumerate(pairwise(self.torque_plan)):
            if after.time <= before.time:
                raise InputError(
                    f"loads.torque_plan.{index + 1}.time = {after.time:g} s is not after the {before.time:g} s of the "
                    "point before: give times that increase"
                )
        if self.torque_plan and self.torque != 0:
            raise InputError(
                f"loads.torque = {self.torque:g} N m and loads.torque_plan exclude each other: give one of them"
            )
        if not self.torque_at:
            raise InputError("loads.torque_at is empty: give where the torque acts, such as gearbox")

    @property
    def with_torque(self) -> bool:
        """Whether there is a torque at any time."""
        return self.torque != 0 or bool(self.torque_plan)

    @property
    def none(self) -> bool:
        """Whether nothing is superposed."""
        fitted = self.press_fit.wheels or self.press_fit.equipment
        return not (self.with_torque or self.stresses or fitted or self.own_weight or any(self.lateral.forces))

    def check_change(self, new: Loads) -> None:
        """Raise InputError if ``new`` cannot follow during a run: torque and rate may change, a plan may end."""
        for key in dataclasses.fields(self):
            fixed = key.name not in ("torque", "torque_rate", "torque_plan")
            if fixed and getattr(new, key.name) != getattr(self, key.name):
                raise InputError(f"loads.{key.name} cannot change during a run: start a new one with the new value")
        if new.torque_plan not in ((), self.torque_plan):
            raise InputError(
                "loads.torque_plan cannot change during a run: give torque, which ends the plan, or start a new run"
            )

    def check_against(self, wheelset: AnyWheelset) -> None:
        """Raise InputError for a node or a part that a wheelset does not have, or a load that it cannot take."""
        nodes = [node.name for node in wheelset.stress_nodes]
        for index, item in enumerate(self.stresses):
            if item.node not in nodes:
                where = f"loads.stresses.{index}.node = {item.node!r}"
                raise InputError(unknown("stress node of this wheelset", where, item.node, nodes))
        if self.with_torque:
            for index, part in enumerate(self.torque_at):
                if part not in wheelset.torque_parts:
                    where = f"loads.torque_at.{index} = {part!r}"
                    raise InputError(
                        unknown("part of this wheelset that takes a torque", where, part, wheelset.torque_parts)
                    )
        if not isinstance(wheelset, ImportedWheelset):
            return
        if self.press_fit.wheels or self.press_fit.equipment:
            raise InputError(
                f"loads.press_fit needs the geometry of seats and hubs, and wheelset {wheelset.name} is imported: "
                "give its stress in loads.stresses"
            )
        for key, wanted in (("horizontal_bending", self.horizontal_bending), ("lateral", any(self.lateral.forces))):
            if wanted:
                raise InputError(
                    f"loads.{key} needs the geometry of the axle, and wheelset {wheelset.name} is imported: "
                    "give its stress in loads.stresses"
                )
        for node in wheelset.stress_nodes:
            if self.with_torque and node.diameter is None:
                raise InputError(
                    f"wheelset.stress_nodes.{node.name}.diameter is missing: loads.torque needs the diameter of "
                    "the axle there, m"
                )
            if self.own_weight and not node.own_weight:
                raise InputError(
                    f"wheelset.stress_nodes.{node.name}.own_weight is missing: loads.own_weight needs the stress of "
                    "gravity alone there; give its 6 components, Pa, or set loads.own_weight to false"
                )

    def check_weight(self, wheelset: AnyWheelset, axle_load: float) -> None:
        """Raise InputError if ``axle_load``, N, is less than the own weight of a wheelset, where that counts."""
        if self.own_weight and axle_load < (weight := GRAVITY * mass_of(wheelset)):
            raise InputError(
                f"axle_load = {axle_load:g} N is less than the wheelset weighs alone, {weight:.0f} N: give at least "
                "that, or set loads.own_weight to false"
            )
