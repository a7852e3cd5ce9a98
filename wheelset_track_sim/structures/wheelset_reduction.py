"""From a wheelset to its reduced model: harmonics, modes, damping, complex poles and stress nodes; and mode shapes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..cache import cached, digest
from ..stress import principal
from . import harmonic_elements, section_mesh, wheelset_harmonics, wheelset_mesh, wheelset_parts
from . import reduced_wheelset as reduced_module
from . import wheelset as wheelset_module
from .harmonic_elements import nodal_stress, solid_mass
from .reduced_wheelset import COMPONENTS, ReducedWheelset
from .section_mesh import SectionMesh
from .wheelset import Wheelset
from .wheelset_harmonics import HARMONICS, harmonic

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[str, float], None]

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


def reduced_wheelset(
    wheelset: Wheelset, *, max_frequency: float = MAX_FREQUENCY, progress: Progress | None = None
) -> ReducedWheelset:
    """Reduced model from the cache of models, built if it is not there; arguments as of `build_reduced_wheelset`."""
    geometry = (wheelset_parts, wheelset_module, section_mesh, wheelset_mesh)
    mechanics = (harmonic_elements, wheelset_harmonics, reduced_module, principal, sys.modules[__name__])
    key = digest([wheelset, max_frequency], *geometry, *mechanics)

    def build() -> ReducedWheelset:
        return build_reduced_wheelset(wheelset, max_frequency=max_frequency, progress=progress)

    return cached("wheelset", ReducedWheelset, key, build)


def build_reduced_wheelset(
    wheelset: Wheelset, *, max_frequency: float = MAX_FREQUENCY, progress: Progress | None = None
) -> ReducedWheelset:
    """Reduced model with all modes of harmonics 0 to 6 to ``max_frequency`` Hz.

    ``progress`` is called with a stage and the fraction done (0 to 1).
    """
    report = progress or (lambda stage, fraction: None)
    report("wheelset mesh", 0.0)
    mesh = wheelset_mesh.wheelset_mesh(wheelset)
    arcs = [wheelset_mesh.stress_fillet(wheelset, node) for node in wheelset.stress_nodes]
    candidates = mesh.nodes_on(np.concatenate(arcs)) if arcs else np.zeros(0, dtype=np.int64)
    parts = []
    for n in HARMONICS:
        report(f"wheelset modes, n = {n}", n / len(HARMONICS))
        parts.append(_poles(wheelset, mesh, n, candidates, max_frequency))
    report("wheelset poles", 1.0)

    poles = np.concatenate([part.poles for part in parts])
    order = np.argsort(np.abs(poles), kind="stable")
    poles = poles[order]
    inputs = np.concatenate([part.inputs for part in parts])[order]
    outputs = np.concatenate([part.outputs for part in parts], axis=1)[:, order]
    stress = np.concatenate([part.stress for part in parts], axis=1)[:, order].reshape(-1, 6, len(poles))
    static = sum((part.static_stress for part in parts), np.zeros((6 * len(candidates), 2))).reshape(-1, 6, 2)

    highest = _highest(principal.maximum_principal(static.sum(axis=2)), [len(arc) for arc in arcs])
    stress, static = stress[highest], static[highest]
    places = mesh.points[candidates[highest]]
    return ReducedWheelset(
        poles=poles,
        inputs=inputs,
        outputs=outputs,
        stress_outputs=stress,
        stress_feedthrough=static + (stress / poles @ inputs).real,
        displacement_residual=sum((part.residual for part in parts), np.zeros((2, 2))),
        node_names=tuple(node.name for node in wheelset.stress_nodes),
        node_positions=np.stack([np.zeros(len(places)), places[:, 0], places[:, 1]], axis=1),
        mass=solid_mass(mesh, wheelset.material) + 2 * wheelset.axle_boxes.mass,
        rolling_radius=wheelset.wheel.rolling_radius,
    )


def mode_shapes(wheelset: Wheelset, max_frequency: float = MAX_FREQUENCY) -> tuple[SectionMesh, list[ModeShapes]]:
    """Section mesh of a wheelset and its modes of each harmonic to ``max_frequency`` Hz."""
    mesh = wheelset_mesh.wheelset_mesh(wheelset)
    found = []
    for n in HARMONICS:
        model = harmonic(wheelset, mesh, n)
        frequencies, modes = model.modes(max_frequency)
        found.append(ModeShapes(n, frequencies, (model.free @ modes).T.reshape(len(frequencies), len(mesh.points), 3)))
    return mesh, found


def _poles(wheelset: Wheelset, mesh: SectionMesh, n: int, nodes: NDArray[np.int64], max_frequency: float) -> Poles:
    """Modes of harmonic ``n`` with Rayleigh damping and the full modal matrix of the suspension's dashpots."""
    model = harmonic(wheelset, mesh, n)
    frequencies, modes = model.modes(max_frequency)
    omega = 2 * np.pi * frequencies
    contacts, boxes = modes.T @ model.contacts, modes.T @ model.boxes
    turned = sp.block_diag([top_of_axle(n)] * len(nodes)) if len(nodes) else sp.coo_array((0, 0))
    stress = (turned @ nodal_stress(mesh, wheelset.material, n, nodes) @ model.free).tocsr()

    material = wheelset.material
    damping = np.diag(material.mass_damping + material.stiffness_damping * omega**2)
    damping += wheelset.axle_boxes.damping * boxes @ boxes.T
    poles, left, right = diagonalised(omega, damping)
    static = model.static(model.contacts)
    return Poles(
        poles=poles,
        inputs=left @ contacts,
        outputs=contacts.T @ right,
        stress=(stress @ modes) @ right,
        residual=model.contacts.T @ static - contacts.T @ (contacts / omega[:, None] ** 2),
        static_stress=stress @ static,
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


def top_of_axle(n: int) -> Real:
    """Matrix (6, 6) from stress amplitudes of harmonic ``n`` to components in x, y, z at theta = pi.

    There r points up, theta against x, cos(n theta) is (-1)^n and sin(n theta) is 0.
    """
    matrix = np.zeros((6, 6))
    matrix[[COMPONENTS.index(name) for name in ("zz", "yy", "xx", "yz")], [0, 1, 2, 3]] = (-1.0) ** n
    return matrix


def _highest(values: Real, lengths: list[int]) -> NDArray[np.int64]:
    """Index of the highest of consecutive groups of values."""
    starts = np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int64) if lengths else np.zeros(0, dtype=np.int64)
    return np.array(
        [start + values[start : start + count].argmax() for start, count in zip(starts, lengths, strict=True)],
        dtype=np.int64,
    )
