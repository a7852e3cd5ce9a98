"""The harmonic model of the X40 against 20-node bricks on the same section mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from support.wheelset_bricks import Bricks, bricks, on_bricks
from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress
from wheelset_track_sim.wheelset.harmonics import HARMONICS, harmonic
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import stress_fillet, wheelset_mesh
from wheelset_track_sim.wheelset.section_mesh import SectionMesh
from wheelset_track_sim.wheelset.stress_points import around_axle
from wheelset_track_sim.wheelset.wheelset import MeshSize, Wheelset

pytestmark = pytest.mark.slow

SIZE = MeshSize(axle=0.05, radial=0.033, fillet=0.008, attached=0.05)
"""Coarse, for the bricks' sake; both models have the same section mesh, so its error is in both."""
SECTORS = 10
LOAD = 98.1e3


@dataclass(frozen=True, eq=False)
class Pair:
    wheelset: Wheelset
    mesh: SectionMesh
    solid: Bricks


@pytest.fixture(scope="module")
def pair() -> Pair:
    x40 = load_wheelset("x40")
    mesh = wheelset_mesh(x40, SIZE)
    return Pair(x40, mesh, bricks(x40, mesh, SECTORS))


def test_modes_agree(pair: Pair) -> None:
    frequencies, shapes = pair.solid.modes(60)
    weighted = pair.solid.mass @ shapes
    compared = {}
    for n in (0, 1, 2):
        model = harmonic(pair.wheelset, pair.mesh, n)
        own, modes = model.modes(0.98 * frequencies.max())
        differences = []
        for frequency, mode in zip(own, modes.T, strict=True):
            field = on_bricks(pair.solid, model, mode)
            # Half of the energy is in half of the model.
            match = (field @ weighted) ** 2 / (field @ (pair.solid.mass @ field))
            near = np.abs(frequencies / frequency - 1) < 0.02
            assert match[near].sum() > 0.99, f"n = {n}: no such mode near {frequency:.1f} Hz"
            differences.append(abs(frequencies[near] @ match[near] / match[near].sum() / frequency - 1))
        compared[n] = (len(own), max(differences))
    assert compared[0][0] >= 5
    assert compared[1][0] >= 12
    assert compared[0][1] < 2e-4
    assert compared[1][1] < 2e-4
    # Higher harmonics: within what the bricks resolve of cos(n theta) over half the circumference.
    assert compared[2][1] < 3e-3


def test_static_stresses_agree(pair: Pair) -> None:
    solid, mesh, x40 = pair.solid, pair.mesh, pair.wheelset
    arcs = [mesh.nodes_on(stress_fillet(x40, node, SIZE)) for node in x40.stress_nodes]
    nodes = np.concatenate(arcs)
    stress = np.zeros((len(nodes), 6))
    for n in HARMONICS:
        model = harmonic(x40, mesh, n)
        static = model.free @ model.static(model.contacts @ np.array([LOAD, LOAD]))
        stress += (nodal_stress(mesh, x40.material, n, nodes) @ static).reshape(-1, 6) @ around_axle(n, 0.0).T

    contacts = mesh.nodes_on(np.array([[y, x40.wheel.rolling_radius] for y in x40.contact_positions]))
    force = np.zeros((len(solid.points), 3))
    force[solid.numbers[contacts, 0], 1] = -LOAD / 2  # upwards, half on half the model
    loads = force.ravel()[solid.free]
    # The wheelset is free along y: a shift of 1e-6 of the first mode's leaves everything else as it is.
    displacements = solid.full(solid.factors(1e-3).solve(loads))
    reference = np.empty_like(stress)
    for place, node in enumerate(nodes):
        yy, down, across, shear, *_ = solid.stress(int(solid.numbers[node, -1]), displacements)
        reference[place] = [across, yy, down, 0.0, 0.0, -shear]
    for arc in arcs:
        on = np.isin(nodes, arc)
        highest = maximum_principal(reference[on]).max()
        assert maximum_principal(stress[on]).max() == pytest.approx(highest, rel=0.01)
        assert stress[on] == pytest.approx(reference[on], abs=0.01 * highest)
