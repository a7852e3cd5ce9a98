"""From a wheelset to its reduced model: harmonics, modes, damping, complex poles and stress nodes; and mode shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..runtime.arrays import Complex, Real
from ..runtime.cache import cached
from ..runtime.progress import Progress, unreported
from . import stress_points
from .harmonic_elements import nodal_stress
from .harmonics import HARMONICS, harmonic, total_mass
from .mesh import wheelset_mesh
from .reduced import ReducedWheelset
from .section_mesh import SectionMesh
from .sensor_rows import SensorRow, box_weights, point_weights, rates, strain_shapes
from .stress_points import StressPoints
from .vehicle import Vehicle, on_vehicle
from .wheelset import Wheelset

MAX_FREQUENCY = 6000.0
"""Hz; modes to here give receptances and stresses to 2500 Hz within 1 %."""


@dataclass(frozen=True, eq=False)
class ModeShapes:
    """Undamped modes of harmonic ``n`` on the section mesh, for drawing and checking."""

    n: int
    frequencies: Real
    """(modes,) Hz."""
    shapes: Real
    """(modes, nodes, 3): amplitudes of u_r, u_y (cos n theta), u_theta (sin n theta); the contact is at theta = 0."""


@dataclass(frozen=True, eq=False)
class Poles:
    """Modes of one harmonic with damping, in the form of `ReducedWheelset`; stress rows are those asked for."""

    poles: Complex
    inputs: Complex
    outputs: Complex
    stress: Complex
    residual: Real
    """(2, 2) static compliance less that of the modes, m/N."""
    static_stress: Real
    """(rows, 2) static stress of the finite elements over force, Pa/N."""
    sensors: Complex
    """(S, modes) to the rows of sensors."""
    sensor_feedthrough: Real
    """(S, 2) of their forces."""


def reduced_wheelset(
    wheelset: Wheelset,
    *,
    max_frequency: float = MAX_FREQUENCY,
    vehicle: Vehicle | None = None,
    rows: Sequence[SensorRow] = (),
    progress: Progress | None = None,
) -> ReducedWheelset:
    """Reduced model from the cache of models, built if it is not there; arguments as of `build_reduced_wheelset`."""
    build = build_reduced_wheelset
    return cached("wheelset", ReducedWheelset, build, wheelset, max_frequency, vehicle, tuple(rows), progress=progress)


def build_reduced_wheelset(
    wheelset: Wheelset,
    max_frequency: float = MAX_FREQUENCY,
    vehicle: Vehicle | None = None,
    rows: tuple[SensorRow, ...] = (),
    progress: Progress | None = None,
) -> ReducedWheelset:
    """Reduced model with all modes of harmonics 0 to 6 to ``max_frequency`` Hz, and with those of a vehicle.

    ``rows`` are what sensors read. ``progress`` is called with a stage and the fraction done (0 to 1).
    """
    report = progress or unreported
    report("wheelset mesh", 0.0)
    mesh = wheelset_mesh(wheelset)
    samples = stress_points.stress_points(wheelset, mesh)
    parts = []
    for n in HARMONICS:
        report(f"wheelset modes, n = {n}", n / len(HARMONICS))
        parts.append(_poles(wheelset, mesh, n, samples, max_frequency, vehicle if n == 1 else None, rows))
    report("wheelset poles", 1.0)

    poles = np.concatenate([part.poles for part in parts])
    order = np.argsort(np.abs(poles), kind="stable")
    poles = poles[order]
    inputs = np.concatenate([part.inputs for part in parts])[order]
    outputs = np.concatenate([part.outputs for part in parts], axis=1)[:, order]
    stress = np.concatenate([part.stress for part in parts], axis=1)[:, order].reshape(-1, 6, len(poles))
    static = sum((part.static_stress for part in parts), np.zeros((6 * len(samples.nodes), 2))).reshape(-1, 6, 2)

    picks = samples.picks(static.sum(axis=2))
    stress, static = stress_points.combined(stress, picks), stress_points.combined(static, picks)
    y = stress_points.combined(mesh.points[samples.nodes, 0], picks)
    return ReducedWheelset(
        poles=poles,
        inputs=inputs,
        outputs=outputs,
        stress_outputs=stress,
        stress_feedthrough=static + (stress / poles @ inputs).real,
        displacement_residual=sum((part.residual for part in parts), np.zeros((2, 2))),
        node_names=tuple(node.name for node in wheelset.stress_nodes),
        node_positions=stress_points.positions(wheelset, wheelset.stress_nodes, y),
        mass=total_mass(wheelset, mesh),
        rolling_radius=wheelset.wheel.rolling_radius,
        sensor_outputs=np.concatenate([part.sensors for part in parts], axis=1)[:, order],
        sensor_feedthrough=sum((part.sensor_feedthrough for part in parts), np.zeros((len(rows), 2))),
    )


def mode_shapes(wheelset: Wheelset, max_frequency: float = MAX_FREQUENCY) -> tuple[SectionMesh, list[ModeShapes]]:
    """Section mesh of a wheelset and its modes of each harmonic to ``max_frequency`` Hz."""
    mesh = wheelset_mesh(wheelset)
    found = []
    for n in HARMONICS:
        model = harmonic(wheelset, mesh, n)
        frequencies, modes = model.modes(max_frequency)
        found.append(ModeShapes(n, frequencies, (model.free @ modes).T.reshape(len(frequencies), len(mesh.points), 3)))
    return mesh, found


def _poles(
    wheelset: Wheelset,
    mesh: SectionMesh,
    n: int,
    samples: StressPoints,
    max_frequency: float,
    vehicle: Vehicle | None,
    rows: Sequence[SensorRow],
) -> Poles:
    """Modes of harmonic ``n`` with Rayleigh damping and the full modal matrix of the dashpots."""
    model = harmonic(wheelset, mesh, n)
    frequencies, modes = model.modes(max_frequency)
    omega = 2 * np.pi * frequencies
    contacts, boxes = modes.T @ model.contacts, modes.T @ model.boxes
    stress = (samples.turned(n) @ nodal_stress(mesh, wheelset.material, n, samples.nodes) @ model.free).tocsr()

    material = wheelset.material
    damping = np.diag(material.mass_damping + material.stiffness_damping * omega**2)
    spring, dashpot = wheelset.axle_boxes.stiffness, wheelset.axle_boxes.damping
    damping += dashpot * boxes @ boxes.T
    if wheelset.axle_boxes.bearing_damping is not None:
        bearings = modes.T @ model.bearings
        damping += wheelset.axle_boxes.bearing_damping * bearings @ bearings.T
    static = model.static(model.contacts)
    residual = model.contacts.T @ static - contacts.T @ (contacts / omega[:, None] ** 2)
    modal_stress = stress @ modes
    gauges = strain_shapes(rows, wheelset, mesh, n) @ model.free
    strain, points, frame = gauges @ modes, point_weights(rows, mesh, n, model.free @ modes), None
    if vehicle is not None:
        coupled = partial(on_vehicle, omega, damping, boxes, spring=spring, dashpot=dashpot, vehicle=vehicle)
        strain = coupled(stress=strain).stress
        omega, damping, shapes, frame, modal_stress = coupled(stress=modal_stress)
        contacts, boxes, points = shapes.T @ contacts, shapes.T @ boxes, points @ shapes
    poles, left, right = diagonalised(omega, damping)
    inputs = left @ contacts
    weights = points + box_weights(rows, boxes, frame, spring, dashpot)
    weights[:, 0] += strain
    sensors, sensor_feedthrough = rates(weights, right, poles, inputs)
    return Poles(
        poles=poles,
        inputs=inputs,
        outputs=contacts.T @ right,
        stress=modal_stress @ right,
        residual=residual,
        static_stress=stress @ static,
        sensors=sensors,
        sensor_feedthrough=sensor_feedthrough + gauges @ static + (strain @ right / poles @ inputs).real,
    )


def diagonalised(omega: Real, damping: Real) -> tuple[Complex, Complex, Complex]:
    """Poles (P,), ``left`` (P, modes) and ``right`` (modes, P) of ``u'' + damping u' + omega^2 u = f``.

    They make it ``q' = poles q + left f`` and ``u = Re(right q)``. The first-order system in (omega u, u') is
    diagonalised; of conjugate pairs the upper is kept, with factor 2.
    """
    modes = len(omega)
    system = np.block([[np.zeros((modes, modes)), np.diag(omega)], [-np.diag(omega), -damping]])
    poles, vectors = np.linalg.eig(system)
    left = np.linalg.inv(vectors)[:, modes:]
    right = vectors[:modes] / omega[:, None]
    real = np.abs(poles.imag) <= 1e-12 * np.abs(poles)
    kept = real | (poles.imag > 0)
    return poles[kept], left[kept], np.where(real, 1.0, 2.0)[kept] * right[:, kept]
