"""What a wheelset is: axle, wheels, brake discs, gearbox, axle boxes, suspension, material; read from YAML.

``y`` is the axial coordinate, 0 at the track's centre, positive to the left in the running direction. Wheel 1 is at
negative y (right), wheel 2 at positive y (left, next to the gearbox). Wheels and brake discs are symmetric about
y = 0 and given by their distance from it; the axle and the gearbox are given by y itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from ..errors import InputError
from ..inputs.schema import quantity
from .parts import Axle, AxleBoxes, BrakeDiscs, Checked, Gearbox, Material, Wheel, increasing
from .stress_node import StressNode, check_stress_nodes

LARGEST_SHIFT = 0.035
"""Of a contact from the rolling circle, m: nearer to flange or rim no contact is solved."""


@dataclass(frozen=True)
class OnAxle(Checked):
    """Equipment on a cylinder of the axle from ``y - length / 2`` to ``y + length / 2``."""

    name: str
    y: float = quantity("m", -2.0, 2.0, "the y of its middle")
    length: float = quantity("m", 0.01, 1.0, "the length of axle that it occupies")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.name:
            raise InputError("equipment has an empty name: give each piece a name of its own")

    @property
    def ends(self) -> tuple[float, float]:
        """First and last y, m."""
        return self.y - self.length / 2, self.y + self.length / 2


@dataclass(frozen=True)
class Ring(OnAxle):
    """Hollow cylinder of the wheelset's material, tied to the axle: it adds mass and stiffness, as the gearbox does."""

    type: ClassVar[str] = "ring"
    outer_radius: float = quantity("m", 0.05, 0.7, "the outer radius of the ring")


@dataclass(frozen=True)
class PointMass(OnAxle):
    """Rigid mass without stiffness; it follows the mean lift and tilt of the axle's surface under it."""

    type: ClassVar[str] = "mass"
    mass: float = quantity("kg", 0.0, 2000.0, "the mass")
    inertia: float = quantity("kg m^2", 0.0, 500.0, "the moment of inertia about a diameter of the axle", default=0.0)


Equipment = Ring | PointMass


def clear_of_each_other(parts: list[tuple[str, float, float]]) -> None:
    """Raise InputError unless parts (what, first y, last y) are beside each other; touching is fine."""
    ordered = sorted(parts, key=lambda part: part[1])
    for (before, _, end), (after, start, _) in pairwise(ordered):
        if start < end - 1e-9:
            raise InputError(
                f"{after} begins at y = {start:g} m, inside {before}, which ends at {end:g} m: move one of them"
            )


@dataclass(frozen=True)
class MeshSize(Checked):
    """Largest length of element sides."""

    axle: float = quantity("m", 0.005, 0.1, "the element size along the axle", default=0.035)
    radial: float = quantity("m", 0.005, 0.1, "the mean element size across the axle", default=0.024)
    fillet: float = quantity("m", 0.001, 0.05, "the element size along the fillets of stress nodes", default=0.004)
    attached: float = quantity("m", 0.005, 0.1, "the element size in wheels, discs and gearbox", default=0.025)

    def divided(self, by: float) -> MeshSize:
        """Size of a mesh that is finer by a factor."""
        return MeshSize(self.axle / by, self.radial / by, self.fillet / by, self.attached / by)


@dataclass(frozen=True)
class Wheelset:
    """Geometry, material and supports of a wheelset: all that its finite-element model needs. SI units."""

    name: str
    axle: Axle
    wheel: Wheel
    axle_boxes: AxleBoxes
    material: Material
    brake_discs: BrakeDiscs | None = None
    gearbox: Gearbox | None = None
    equipment: tuple[Equipment, ...] = ()
    """Further rings and masses on the axle."""
    stress_nodes: tuple[StressNode, ...] = ()
    mesh: MeshSize = MeshSize()
    contact_shifts: tuple[float, float] = (0.0, 0.0)
    """Where the rails touch wheels 1 and 2, from their rolling circles, to the left positive, m."""

    def __post_init__(self) -> None:
        for shift in self.contact_shifts:
            if not abs(shift) <= LARGEST_SHIFT:
                raise InputError(
                    f"contact_shifts has {shift:g} m: give distances from the rolling circles up to {LARGEST_SHIFT:g} m"
                )
        check_stress_nodes(self.stress_nodes, self.axle, self.attached)
        for side in (-1, 1):
            low, high = sorted((side * self.wheel.hub_inner, side * self.wheel.hub_outer))
            seat = self.axle.section_over(low, high, "wheel hub")
            increasing("wheel", seat=seat.diameter / 2, hub_radius=self.wheel.hub_radius)
            middle, half = side * self.axle_boxes.distance, self.axle_boxes.bearing_length / 2
            self.axle.section_over(middle - half, middle + half, "bearing of the axle box")
        if self.gearbox:
            increasing("gearbox", end=max(map(abs, self.gearbox_ends)), hub_inner=self.wheel.hub_inner)
            seat = self.axle.section_over(*self.gearbox_ends, "gearbox")
            increasing("gearbox", seat=seat.diameter / 2, outer_radius=self.gearbox.outer_radius)
        if self.brake_discs:
            increasing(
                "brake_discs",
                hub_radius=self.wheel.hub_radius,
                inner_radius=self.brake_discs.inner_radius,
                outer_radius=self.brake_discs.outer_radius,
                rim_radius=self.wheel.rim_radius,
            )
        self._check_equipment()

    def _check_equipment(self) -> None:
        names = [item.name for item in self.equipment]
        if len({*names, "gearbox"}) <= len(names):
            raise InputError(f"equipment has names {', '.join(names)}: give each a name of its own, and not gearbox")
        for item in self.equipment:
            seat = self.axle.section_over(*item.ends, item.name)
            if isinstance(item, Ring):
                increasing(item.name, seat=seat.diameter / 2, outer_radius=item.outer_radius)
        clear_of_each_other([*self.attached, *((item.name, *item.ends) for item in self.masses)])

    @property
    def rolling_radius(self) -> float:
        """Radius of the treads, m."""
        return self.wheel.rolling_radius

    @property
    def rings(self) -> tuple[Ring, ...]:
        """Equipment that is part of the solid."""
        return tuple(item for item in self.equipment if isinstance(item, Ring))

    @property
    def masses(self) -> tuple[PointMass, ...]:
        """Equipment that is a mass on the axle's surface."""
        return tuple(item for item in self.equipment if isinstance(item, PointMass))

    @property
    def torque_parts(self) -> list[str]:
        """Names of the parts at which a torque can act."""
        gearbox = ["gearbox"] if self.gearbox else []
        return [*gearbox, *(item.name for item in self.equipment), "wheel_1", "wheel_2"]

    @property
    def attached(self) -> tuple[tuple[str, float, float], ...]:
        """Parts of the solid that cover the axle's surface: what, first and last y, m."""
        inner, outer = self.wheel.hub_inner, self.wheel.hub_outer
        hubs = [("the hub of wheel 1", -outer, -inner), ("the hub of wheel 2", inner, outer)]
        gearbox = [("gearbox", *self.gearbox_ends)] if self.gearbox else []
        return (*hubs, *gearbox, *((ring.name, *ring.ends) for ring in self.rings))

    @property
    def gearbox_ends(self) -> tuple[float, float]:
        """First and last y of the gearbox, m."""
        assert self.gearbox is not None
        return self.gearbox.y - self.gearbox.length / 2, self.gearbox.y + self.gearbox.length / 2

    @property
    def rolling_circles(self) -> tuple[float, float]:
        """Of wheels 1 and 2: y, m."""
        return -self.wheel.contact, self.wheel.contact

    @property
    def contact_positions(self) -> tuple[float, float]:
        """Contact points of wheels 1 and 2: y, m."""
        first, second = self.rolling_circles
        return first + self.contact_shifts[0], second + self.contact_shifts[1]
