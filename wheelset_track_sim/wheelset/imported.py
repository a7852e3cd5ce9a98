"""A wheelset's modes and stresses from another finite-element program: what the file holds, and its reduced model.

``docs/reference/wheelsets.md`` describes the format. Shapes have one normalisation: with the modal mass m and the
shape phi at the contacts, ``m (q'' + 2 zeta omega q' + omega^2 q) = phi . F``, the wheels lift by ``phi q``, and
stress is modal stress times q. The suspension's dashpots are given by the lift at them: they couple the modes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, pi

import numpy as np

from ..errors import InputError
from ..inputs.schema import Quantity, check, quantity
from ..runtime.arrays import Real
from .around import Around, angles_of
from .reduced import ReducedWheelset
from .reduction import diagonalised
from .sensor_rows import NamedMotion, SensorRow, SuspensionReaction, box_weights, rates
from .static_loads import nominal_torsion
from .stress_node import NAME, check_names
from .vehicle import Vehicle, on_vehicle

Numbers = tuple[float, ...]
Rows = tuple[Numbers, ...]

FREQUENCY = Quantity("Hz", 0.1, 1e5, "the natural frequency of the wheelset on its suspension")
DAMPING = Quantity("", 1e-7, 5.0, "the damping ratio")
MASS = Quantity("kg", 1e-12, 1e12, "the modal mass")
ONE_SUSPENSION = 0.02
"""Share by which the stiffnesses of both suspensions may differ that follow from the modes."""
IN_COMMON = 5.0
"""Factor between the stress of all modes and the static stress, at which units or normalisation are not the same."""


@dataclass(frozen=True)
class Modes:
    """P modes; frequencies and damping ratios, or poles."""

    lift: Rows
    """(P, 2) at the contact points of wheel 1 and 2, positive upwards."""
    frequencies: Numbers = ()
    """(P,) Hz, undamped."""
    damping_ratios: Numbers = ()
    """(P,), without what ``suspension_damping`` adds."""
    poles: Rows = ()
    """(P, 2) instead of both: real and imaginary part of the upper one of each pair, rad/s."""
    modal_masses: Numbers = ()
    """(P,) kg, or kg times the square of the shapes' unit; 1 if not given."""
    suspension: Rows = ()
    """(P, 2) lift at the suspension next to wheel 1 and 2."""


@dataclass(frozen=True)
class ImportedNode:
    """A stress node with its stresses: components xx, yy, zz, xy, xz, yz."""

    name: str
    position: Numbers
    """x, y, z from the middle of the axle, m."""
    modal: Rows
    """(P, 6) Pa for a unit of each mode."""
    static: Rows
    """(2, 6) Pa/N: by 1 N upwards on wheel 1, and on wheel 2."""
    diameter: float | None = quantity("m", 0.05, 0.4, "the axle's diameter at the node", default=None)
    """Of the axle there, m: torque needs it."""
    own_weight: Numbers = ()
    """(6,) Pa: by the wheelset's own weight, hung up in its suspension; ``loads.own_weight`` needs it."""

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise InputError(f"stress node {self.name!r} cannot name a topic: give letters, digits, single underscores")
        check(self, self.name)


@dataclass(frozen=True)
class MeasuringPoint:
    """A node of the model whose vertical motion a sensor can measure."""

    name: str
    modal_lift: Numbers
    """(P,) lift of the modes there, positive upwards, normalised as ``modes.lift``."""
    position: Numbers = ()
    """x, y, z from the middle of the axle, m; for people."""

    def __post_init__(self) -> None:
        if not NAME.fullmatch(self.name):
            raise InputError(f"measuring point {self.name!r} is no name: give letters, digits, single underscores")


@dataclass(frozen=True)
class TorquePlace:
    """A part at which a torque can act."""

    name: str
    y: float = quantity("m", -2.0, 2.0, "the y of the part")


@dataclass(frozen=True)
class ImportedWheelset:
    """Content of the file; SI units, y positive to the left, wheel 1 on the right."""

    imported: int
    """Version of the format: 1."""
    name: str
    modes: Modes
    rolling_radius: float = quantity("m", 0.15, 0.75, "the radius of the tread")
    mass: float = quantity("kg", 100.0, 1e4, "the mass with axle boxes")
    contacts: Numbers = (-0.75, 0.75)
    """y of the contact points of wheel 1 and 2, m."""
    stress_nodes: tuple[ImportedNode, ...] = ()
    suspension_damping: float = quantity("N s/m", 0.0, 1e6, "the damping of one primary suspension", default=0.0)
    static_lift: Rows = ()
    """(2, 2) m/N: lift of wheel 1, 2 (rows) by 1 N on wheel 1, 2, if the residual compliance is wanted."""
    torque_places: tuple[TorquePlace, ...] = ()
    measuring_points: tuple[MeasuringPoint, ...] = ()
    """Nodes for sensors."""

    def __post_init__(self) -> None:
        check(self)
        if self.imported != 1:
            raise InputError(f"imported = {self.imported} is not a known version of the format: give 1")
        modes, found = self.modes, len(self.modes.lift)
        if not found:
            raise InputError("modes.lift is empty: give at least one mode")
        if bool(modes.poles) == bool(modes.frequencies and modes.damping_ratios):
            raise InputError("modes needs either poles, or frequencies with damping_ratios: give one of the two")
        _shape("contacts", self.contacts, 2)
        for name, columns in (("lift", 2), ("suspension", 2), ("poles", 2)):
            _shape(f"modes.{name}", getattr(modes, name), found, columns, optional=name != "lift")
        for name, what in (("frequencies", FREQUENCY), ("damping_ratios", DAMPING), ("modal_masses", MASS)):
            values = getattr(modes, name)
            _shape(f"modes.{name}", values, found, optional=True)
            _check_each(what, f"modes.{name}", values)
        for index, (real, imaginary) in enumerate(modes.poles):
            _check_each(FREQUENCY, f"modes.poles.{index} (frequency)", [hypot(real, imaginary) / (2 * pi)])
            _check_each(DAMPING, f"modes.poles.{index} (damping ratio)", [-real / hypot(real, imaginary)])
        if self.suspension_damping and not modes.suspension:
            raise InputError("suspension_damping needs the modes' lift there: give modes.suspension")
        _shape("static_lift", self.static_lift, 2, 2, optional=True)
        check_names([node.name for node in self.stress_nodes])
        for node in self.stress_nodes:
            _shape(f"stress_nodes.{node.name}.position", node.position, 3)
            _shape(f"stress_nodes.{node.name}.modal", node.modal, found, 6)
            _shape(f"stress_nodes.{node.name}.static", node.static, 2, 6)
            _shape(f"stress_nodes.{node.name}.own_weight", node.own_weight, 6, optional=True)
        for point in self.measuring_points:
            _shape(f"measuring_points.{point.name}.modal_lift", point.modal_lift, found)
            _shape(f"measuring_points.{point.name}.position", point.position, 3, optional=True)
        names = [point.name for point in self.measuring_points]
        if len({*names}) < len(names):
            raise InputError(f"measuring_points has names {', '.join(names)}: give each a name of its own")
        self._check_units()

    @property
    def rolling_circles(self) -> tuple[float, float]:
        """Of wheels 1 and 2: y, m."""
        return self.contacts[0], self.contacts[1]

    @property
    def places(self) -> dict[str, float]:
        """Y of the parts at which a torque can act, m."""
        wheel_1, wheel_2 = self.contacts
        return {place.name: place.y for place in self.torque_places} | {"wheel_1": wheel_1, "wheel_2": wheel_2}

    @property
    def torque_parts(self) -> list[str]:
        """Names of the parts at which a torque can act."""
        return [*self.places]

    @property
    def suspension_stiffness(self) -> float:
        """Stiffness of one primary suspension, N/m: a force at one lifts it by that alone, and the other one not.

        Raises InputError for modes that do not say it.
        """
        if not self.modes.suspension:
            raise InputError("a vehicle needs the modes' lift at the suspension: give modes.suspension")
        omega, norm, *_ = self._normalised()
        boxes = np.array(self.modes.suspension) / norm
        first, second = np.linalg.eigvalsh(boxes.T @ (boxes / omega[:, np.newaxis] ** 2))
        if not second > first > (1.0 - ONE_SUSPENSION) * second:
            raise InputError(
                f"modes.suspension says {1 / second:.4g} and {1 / first:.4g} N/m of two springs, or modes are missing: "
                "give bounce and roll on two equal suspensions"
            )
        return float(1.0 / second)

    def reduced(self, vehicle: Vehicle | None = None, sensors: Sequence[SensorRow] = ()) -> ReducedWheelset:
        """Reduced model of its modes, under a vehicle if there is one, with the rows that ``sensors`` read."""
        modes, (omega, norm, modal, static, of_modes) = self.modes, self._normalised()
        ratios = -np.array(modes.poles)[:, 0] / omega if modes.poles else np.array(modes.damping_ratios)
        lift = np.array(modes.lift) / norm
        damping = np.diag(2 * ratios * omega)
        boxes, frame = np.zeros_like(lift), None
        if modes.suspension:
            boxes = np.array(modes.suspension) / norm
            damping += self.suspension_damping * boxes @ boxes.T
        nodes = len(self.stress_nodes)
        compliance = lift.T @ (lift / omega[:, np.newaxis] ** 2)
        shapes, rows = lift, modal.transpose(0, 2, 1)
        points = self._point_weights(sensors, norm)
        if vehicle is not None:
            spring, dashpot = self.suspension_stiffness, self.suspension_damping
            omega, damping, own, frame, stress = on_vehicle(
                omega, damping, boxes, rows.reshape(-1, len(omega)), spring, dashpot, vehicle
            )
            shapes, rows = own.T @ lift, stress.reshape(nodes, 6, len(omega))
            boxes, points = own.T @ boxes, points @ own
        poles, left, right = diagonalised(omega, damping)
        order = np.argsort(np.abs(poles), kind="stable")
        poles, left, right = poles[order], left[order], right[:, order]
        spring = self.suspension_stiffness if any(isinstance(row, SuspensionReaction) for row in sensors) else 0.0
        weights = points + box_weights(sensors, boxes, frame, spring, self.suspension_damping)
        sensor_outputs, sensor_feedthrough = rates(weights, right, poles, left @ shapes)
        return ReducedWheelset(
            poles=poles,
            inputs=left @ shapes,
            outputs=shapes.T @ right,
            stress_outputs=rows @ right,
            stress_feedthrough=static - of_modes,
            displacement_residual=np.array(self.static_lift) - compliance if self.static_lift else np.zeros((2, 2)),
            node_names=tuple(node.name for node in self.stress_nodes),
            node_positions=self._positions,
            mass=self.mass,
            rolling_radius=self.rolling_radius,
            sensor_outputs=sensor_outputs,
            sensor_feedthrough=sensor_feedthrough,
        )

    def torsion(self, moments: Mapping[str, float]) -> Around:
        """Stress at the nodes under moments about y, N m, by part: that of plain shafts. Raises InputError."""
        diameters = []
        for node in self.stress_nodes:
            if node.diameter is None:
                raise InputError(
                    f"stress_nodes.{node.name}.diameter is missing: torque needs the diameter of the axle there, m"
                )
            diameters.append(node.diameter)
        return nominal_torsion(self._positions[:, 1], diameters, self.places, moments)

    def under_own_weight(self) -> Around:
        """Stress at the nodes of the own weight, which bends the axle in the vertical plane."""
        stresses = np.array([node.own_weight for node in self.stress_nodes]).reshape(-1, 6)
        return Around.vertical_of_points(stresses, angles_of(self._positions))

    def _point_weights(self, sensors: Sequence[SensorRow], norm: Real) -> Real:
        """Weights (S, 3, P) on the modes of the rows of measuring points, as in ``sensor_rows``."""
        weights = np.zeros((len(sensors), 3, len(norm)))
        lifts = {point.name: point.modal_lift for point in self.measuring_points}
        for row, weight in zip(sensors, weights, strict=True):
            if isinstance(row, NamedMotion):
                weight[row.order] = np.array(lifts[row.name]) / norm[:, 0]
        return weights

    @property
    def _positions(self) -> Real:
        """(N, 3) of the nodes, m."""
        return np.array([node.position for node in self.stress_nodes]).reshape(-1, 3)

    def _normalised(self) -> tuple[Real, Real, Real, Real, Real]:
        """Natural frequencies (P,) rad/s, norms of the shapes (P, 1), and stresses at the nodes (nodes, 6, ...).

        The stresses are those of the modes of unit modal mass, the static ones, and what the modes make of those.
        """
        modes, nodes = self.modes, len(self.stress_nodes)
        omega = (
            np.hypot(*np.array(modes.poles).T) if modes.poles else 2 * np.pi * np.array(modes.frequencies, np.float64)
        )
        norm = np.sqrt(modes.modal_masses or np.ones(len(omega)))[:, np.newaxis]
        lift = np.array(modes.lift) / norm
        modal = np.array([np.array(node.modal) / norm for node in self.stress_nodes]).reshape(nodes, len(omega), 6)
        static = np.array([np.transpose(node.static) for node in self.stress_nodes]).reshape(nodes, 6, 2)
        of_modes = np.einsum("npc,pw->ncw", modal, lift / omega[:, np.newaxis] ** 2)
        return omega, norm, modal, static, of_modes

    def _check_units(self) -> None:
        """Raise InputError where modes and static stresses have no unit in common."""
        *_, static, of_modes = self._normalised()
        for node, own, whole in zip(self.stress_nodes, of_modes.sum(axis=2), static.sum(axis=2), strict=True):
            modal, given = float(np.linalg.norm(own)), float(np.linalg.norm(whole))
            if not given / IN_COMMON <= modal <= given * IN_COMMON:
                raise InputError(
                    f"stress_nodes.{node.name}: the modes make {modal:.3g} Pa/N, static says {given:.3g} Pa/N: give "
                    "both in Pa and N, and lift and modal stress with the normalisation of modal_masses"
                )


def _shape(where: str, values: Numbers | Rows, rows: int, columns: int = 0, *, optional: bool = False) -> None:
    if optional and not values:
        return
    if len(values) != rows:
        raise InputError(f"{where} has {len(values)} entries: give {rows}")
    for index, row in enumerate(values):
        if columns and len(row) != columns:  # type: ignore[arg-type]
            raise InputError(f"{where}.{index} has {len(row)} entries: give {columns}")  # type: ignore[arg-type]


def _check_each(what: Quantity, where: str, values: Numbers | list[float]) -> None:
    for index, value in enumerate(values):
        refusal = what.refusal(f"{where}.{index}" if isinstance(values, tuple) else where, value)
        if refusal:
            raise InputError(refusal)
