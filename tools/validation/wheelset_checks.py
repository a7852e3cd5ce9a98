"""What is computed for section 5: facts of the wheelset, a finer mesh, bricks, statics of the finite elements."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.wheelset.around import angles_of
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress
from wheelset_track_sim.wheelset.harmonics import HARMONICS, harmonic
from wheelset_track_sim.wheelset.imported import ImportedWheelset
from wheelset_track_sim.wheelset.kinds import load_wheelset, reduce_wheelset
from wheelset_track_sim.wheelset.mesh import stress_fillet, wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset, reduced_wheelset
from wheelset_track_sim.wheelset.section_mesh import SectionMesh
from wheelset_track_sim.wheelset.static_bending import own_weight_stress
from wheelset_track_sim.wheelset.stress_points import around_axle
from wheelset_track_sim.wheelset.wheelset import MeshSize, Wheelset

from .store import ROOT, recall

Real = NDArray[np.float64]

LOAD = 98.1e3
"""Static wheel load, N."""
COARSE = MeshSize(axle=0.05, radial=0.033, fillet=0.008, attached=0.05)
SECTORS = 10


def bending(reduced: ReducedWheelset) -> float:
    """Natural frequency nearest to 206 Hz."""
    return float(reduced.frequencies[np.abs(reduced.frequencies - 206.0).argmin()])


def strongest(reduced: ReducedWheelset) -> float:
    """Frequency, Hz, at which the axial stress at A1 by a force on wheel 1 peaks highest between 1 and 2.5 kHz."""
    f = np.arange(1000.0, 2500.0, 0.5)
    size = np.abs(reduced.stress_receptance(f)[:, reduced.node("A1"), 1, 0])
    peaks, _ = find_peaks(size)
    return float(f[peaks[size[peaks].argmax()]])


def static(reduced: ReducedWheelset) -> list[float]:
    """Maximum principal stress at each node under the static load on both wheels, MPa."""
    return [float(value) for value in maximum_principal(reduced.static_stress().sum(axis=2) * LOAD) / 1e6]


def _facts(reduced: ReducedWheelset) -> dict[str, Any]:
    return {
        "mass": reduced.mass,
        "first": [float(f) for f in reduced.frequencies[:4]],
        "bending": bending(reduced),
        "strongest": strongest(reduced),
        "static": static(reduced),
        "modes": len(reduced.poles),
        "residual": reduced.displacement_residual.diagonal().tolist(),
        "stress_residual": float(np.abs(reduced.stress_feedthrough).max() / np.abs(reduced.static_stress()).max()),
    }


def facts(changes: tuple[str, ...] = ()) -> dict[str, Any]:
    """Facts of the X40 with changed keys."""

    def compute() -> Any:
        scenario = load_scenario("undamaged", [f"wheelset.{change}" for change in changes])
        return _facts(reduced_wheelset(scenario.wheelset))

    found: dict[str, Any] = recall("wheelset", list(changes), compute)
    return found


def _static_stress(x40: Wheelset, mesh: SectionMesh, nodes: NDArray[np.int64]) -> Real:
    """Static stress (nodes, 6), Pa, on top of the axle by the harmonic elements."""
    stress = np.zeros((len(nodes), 6))
    for n in HARMONICS:
        model = harmonic(x40, mesh, n)
        u = model.free @ model.static(model.contacts @ np.array([LOAD, LOAD]))
        stress += (nodal_stress(mesh, x40.material, n, nodes) @ u).reshape(-1, 6) @ around_axle(n, 0.0).T
    return stress


def _fine() -> Any:
    x40 = load_wheelset("x40")
    fine = build_reduced_wheelset(replace(x40, mesh=x40.mesh.divided(2)), max_frequency=2500.0)
    return _facts(fine)


def _elements() -> Any:
    """Static stresses, MPa, by the finite elements themselves, on the mesh of the reduced model."""
    x40 = load_wheelset("x40")
    mesh, reduced = wheelset_mesh(x40), reduced_wheelset(x40)
    nodes = mesh.nodes_on(reduced.node_positions[:, 1:])
    return [float(value) for value in maximum_principal(_static_stress(x40, mesh, nodes)) / 1e6]


def _bricks() -> Any:
    """Harmonic elements against 20-node bricks on the same section mesh: modes and statics."""
    sys.path.insert(0, str(ROOT / "tests"))
    from support.wheelset_bricks import bricks, on_bricks

    x40 = load_wheelset("x40")
    mesh = wheelset_mesh(x40, COARSE)
    solid = bricks(x40, mesh, SECTORS)
    frequencies, shapes = solid.modes(60)
    weighted = solid.mass @ shapes
    modes = []
    for n in (0, 1, 2):
        model = harmonic(x40, mesh, n)
        own, found = model.modes(0.98 * frequencies.max())
        gaps = []
        for frequency, mode in zip(own, found.T, strict=True):
            field = on_bricks(solid, model, mode)
            match = (field @ weighted) ** 2 / (field @ (solid.mass @ field))
            near = np.abs(frequencies / frequency - 1) < 0.02
            gaps.append(abs(float(frequencies[near] @ match[near] / match[near].sum()) / float(frequency) - 1))
        modes.append([n, len(own), float(own.max()), max(gaps)])

    arcs = [mesh.nodes_on(stress_fillet(x40, node, COARSE)) for node in x40.stress_nodes]
    nodes = np.concatenate(arcs)
    stress, reference = _static_stress(x40, mesh, nodes), np.zeros((len(nodes), 6))
    contacts = mesh.nodes_on(np.array([[y, x40.wheel.rolling_radius] for y in x40.contact_positions]))
    force = np.zeros((len(solid.points), 3))
    force[solid.numbers[contacts, 0], 1] = -LOAD / 2  # upwards, half on half the model
    displacements = solid.full(solid.factors(1e-3).solve(force.ravel()[solid.free]))
    for place, node in enumerate(nodes):
        yy, down, across, shear, *_ = solid.stress(int(solid.numbers[node, -1]), displacements)
        reference[place] = [across, yy, down, 0.0, 0.0, -shear]
    highest = [
        [float(maximum_principal(s[np.isin(nodes, arc)]).max() / 1e6) for s in (stress, reference)] for arc in arcs
    ]
    return {"modes": modes, "static": highest, "unknowns": len(solid.free)}


def _own_weight() -> Any:
    """Static stresses without and with own weight, MPa, by wheelset and by axle load in t."""
    found: dict[str, dict[str, list[list[float]]]] = {}
    for name in ("x40", "trailer", "trailer_calculix"):
        wheelset = load_wheelset(name)
        reduced = reduce_wheelset(wheelset)
        if isinstance(wheelset, ImportedWheelset):
            hung = wheelset.under_own_weight()
        else:
            hung = own_weight_stress(wheelset, reduced.node_positions[:, 1])
        weight, unit = hung.at(angles_of(reduced.node_positions)), reduced.static_stress().sum(axis=2)
        found[name] = {
            str(load): [
                (maximum_principal(unit * load * 9810.0 / 2 + own) / 1e6).tolist() for own in (0.0 * weight, weight)
            ]
            for load in (20, 14, 12)
        }
    return found


def own_weight() -> Any:
    """Maximum principal stresses, MPa, without and with own weight, by wheelset and axle load in t."""
    return recall("own-weight", 1, _own_weight)


def fine() -> Any:
    """Facts of the X40 on a mesh of half the size."""
    return recall("wheelset-fine", 2, _fine)


def elements() -> Any:
    """Static stresses by the finite elements."""
    return recall("wheelset-elements", 1, _elements)


def compared_with_bricks() -> Any:
    """Modes and statics of both models."""
    return recall("bricks", SECTORS, _bricks)
