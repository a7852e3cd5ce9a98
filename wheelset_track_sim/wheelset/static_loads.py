"""Stress of press fits and of torque at places on the axle, by the axisymmetric finite elements (n = 0).

Press fit: hub and axle of one material press with Lamé's pressure; the axle alone, with that pressure evenly on its
seat, answers for the stress beside it. The edge of a real hub presses more than its middle, and friction holds it back
along the axle: both are left out, and matter within a few millimetres of the edge.

Torque: it enters evenly around gearbox, ring or wheel, both rails react at the treads, and the wheelset is in
equilibrium: quasi-static torsion, with the notch factor of each fillet. Twisting vibrations are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ..runtime.arrays import Real
from .around import Around
from .harmonic_elements import free_unknowns, stiffness_and_mass
from .harmonics import held, on_surface
from .mesh import axle_mesh, wheelset_mesh
from .section_mesh import SectionMesh
from .stress_points import surface_amplitudes
from .wheelset import Wheelset


def lame_pressure(
    youngs_modulus: float, interference: float, radius: float, outer_radius: float, bore_radius: float = 0.0
) -> float:
    """Pressure, Pa, between a shaft and a hub of one material; ``interference`` is that of the diameters, m.

    G. Lamé: ``p = E interference / (4 radius) h / (1 + h b^2 / (radius^2 - b^2))`` with the bore's radius ``b`` and the
    hub's part ``h = 1 - (radius / outer_radius)^2``; a solid shaft has b = 0.
    """
    hub = 1 - (radius / outer_radius) ** 2
    bored = bore_radius**2 / (radius**2 - bore_radius**2)
    return youngs_modulus * interference / (4 * radius) * hub / (1 + hub * bored)


def press_fit_stress(wheelset: Wheelset, y: Real, wheels: float, equipment: float) -> Around:
    """Stress at places ``y`` (N,), m, of the axle under the interference of wheels, and of gearbox and rings, m."""
    mesh = axle_mesh(wheelset)
    outer = {f"the hub of wheel {wheel}": (wheelset.wheel.hub_radius, wheels) for wheel in (1, 2)}
    if wheelset.gearbox:
        outer["gearbox"] = wheelset.gearbox.outer_radius, equipment
    outer |= {ring.name: (ring.outer_radius, equipment) for ring in wheelset.rings}
    force = np.zeros(3 * len(mesh.points))
    for what, low, high in wheelset.attached:
        radius = wheelset.axle.section_over(low, high, what).diameter / 2
        outer_radius, interference = outer[what]
        bore = wheelset.axle.bore / 2
        pressure = lame_pressure(wheelset.material.youngs_modulus, interference, radius, outer_radius, bore)
        nodes, weights = on_surface(mesh, radius, low, high)
        np.add.at(force, 3 * nodes, -pressure * 2 * np.pi * radius * (high - low) * weights)
    free = free_unknowns(mesh, 0)
    return _stress(wheelset, mesh, free, force, y)


def torsion_stress(wheelset: Wheelset, y: Real, moments: Mapping[str, float]) -> Around:
    """Stress at places ``y`` (N,), m, of the axle under moments about y, N m, by part; together they are zero.

    Parts are ``gearbox``, equipment by name, ``wheel_1`` and ``wheel_2``, whose moments act at the tread. Raises
    InputError for a part that the wheelset does not have.
    """
    mesh = wheelset_mesh(wheelset)
    force = np.zeros(3 * len(mesh.points))
    for part, moment in moments.items():
        radius, low, high = _grip(wheelset, part)
        nodes, weights = on_surface(mesh, radius, low, high)
        # u_theta turns about -y: at the bottom it points forwards.
        np.add.at(force, 3 * nodes + 2, -moment / radius * weights)
    twisting = np.flatnonzero(mesh.points[:, 1] > 0.0)
    size = 3 * len(mesh.points)
    free = sp.coo_array((np.ones(len(twisting)), (3 * twisting + 2, np.arange(len(twisting)))), (size, len(twisting)))
    return _stress(wheelset, mesh, free.tocsc(), force, y)


def nominal_torsion(
    y: Real, diameters: Sequence[float], places: Mapping[str, float], moments: Mapping[str, float]
) -> Around:
    """Stress at places ``y`` (N,), m, of a solid shaft under moments about y at ``places``, m: tau = 16 T / (pi d^3).

    T is the moment that the part at larger y exerts on the part at smaller y, about y.
    """
    twist = -sum(moment * (places[part] < y) for part, moment in moments.items())
    tau = 16 * twist / (np.pi * np.asarray(diameters, dtype=np.float64) ** 3)
    amplitudes = np.zeros((len(y), 6))
    amplitudes[:, 5] = -tau
    return Around.even(amplitudes)


def reacted(torque_at: Sequence[str], wheel_1_share: float) -> dict[str, float]:
    """Moments about y, N m, by part, of a torque of 1 N m in equal parts, and of both rails that react to it."""
    moments = dict.fromkeys(("wheel_1", "wheel_2", *torque_at), 0.0)
    for part in torque_at:
        moments[part] += 1.0 / len(torque_at)
    moments["wheel_1"] -= wheel_1_share
    moments["wheel_2"] -= 1.0 - wheel_1_share
    return moments


def _grip(wheelset: Wheelset, part: str) -> tuple[float, float, float]:
    """Radius, first and last y, m, of the surface on which a moment acts on a part."""
    if part in ("wheel_1", "wheel_2"):
        y = wheelset.contact_positions[part == "wheel_2"]
        return wheelset.wheel.rolling_radius, y, y
    if part == "gearbox" and wheelset.gearbox:
        return wheelset.gearbox.outer_radius, *wheelset.gearbox_ends
    item = next(item for item in wheelset.equipment if item.name == part)
    radius = getattr(item, "outer_radius", None) or wheelset.axle.section_over(*item.ends, part).diameter / 2
    return radius, *item.ends


def _stress(wheelset: Wheelset, mesh: SectionMesh, free: sp.csc_array, force: Real, y: Real) -> Around:
    """Stress at places ``y`` (N,) under forces (all unknowns,) in equilibrium, held where nothing holds them."""
    whole, _ = stiffness_and_mass(mesh, wheelset.material, 0)
    stiffness = held((free.T @ whole @ free).tocsc(), free)
    displacements = free @ splu(stiffness).solve(free.T @ force)
    return Around.even(surface_amplitudes(wheelset, mesh, 0, displacements, y))
