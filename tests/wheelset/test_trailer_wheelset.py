"""The shipped trailer wheelset: mirrored forces give mirrored stresses, mass and bending are what they ought to be."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh

from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.timoshenko import element_matrices
from wheelset_track_sim.track.track import Beam
from wheelset_track_sim.wheelset.harmonic_elements import solid_mass
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.wheelset import Wheelset

MIRRORED = np.array([1, 1, 1, -1, 1, -1])
"""Signs of xx, yy, zz, xy, xz, yz in a mirror across y."""


@pytest.fixture(scope="module")
def trailer() -> Wheelset:
    return load_wheelset("trailer")


@pytest.fixture(scope="module")
def reduced(trailer: Wheelset) -> ReducedWheelset:
    return build_reduced_wheelset(replace(trailer, mesh=trailer.mesh.divided(0.6)), max_frequency=1500.0)


@pytest.mark.slow
def test_mirrored_forces_give_mirrored_stresses(reduced: ReducedWheelset) -> None:
    stress = reduced.stress_receptance(np.array([0.0, 50.0, 200.0, 1000.0]))
    largest = np.abs(stress).max(axis=(1, 2, 3), keepdims=True)[..., 0]
    for name, mirror in (("A1", "A2"), ("B1", "B2"), ("M", "M")):
        one, other = stress[:, reduced.node(name)], stress[:, reduced.node(mirror)]
        assert (np.abs(one - MIRRORED[:, None] * other[..., ::-1]) < 1e-4 * largest).all()
    receptance = reduced.receptance(np.array([0.0, 50.0, 200.0, 1000.0]))
    assert receptance[:, 0, 0] == pytest.approx(receptance[:, 1, 1], rel=1e-4)


def test_mass_of_a_coachs_wheelset(trailer: Wheelset, reduced: ReducedWheelset) -> None:
    assert 1100.0 < reduced.mass - 2 * trailer.axle_boxes.mass < 1500.0
    disc = trailer.rings[0]
    volume = np.pi * (disc.outer_radius**2 - 0.091**2) * disc.length
    whole, without = (
        solid_mass(wheelset_mesh(wheelset), trailer.material) for wheelset in (trailer, replace(trailer, equipment=()))
    )
    assert whole - without == pytest.approx(2 * trailer.material.density * volume, rel=1e-6)


def test_first_bending_of_the_axle(trailer: Wheelset, reduced: ReducedWheelset) -> None:
    """Against Timoshenko beams between rigid wheels and discs: these stiffen the axle, whose true wheels give way."""
    beams = first_bending_with_rigid_wheels(trailer)
    found = reduced.frequencies[2]
    assert 60.0 < found < 95.0
    assert 0.85 * beams < found < beams


def first_bending_with_rigid_wheels(wheelset: Wheelset) -> float:
    steel, wheel = wheelset.material, wheelset.wheel
    ends = [wheelset.axle.start, *(section.end for section in wheelset.axle.sections)]
    rho = steel.density
    # y, mass, inertia about a diameter
    bodies = [(ring.y, *_disc(rho, 0.091, ring.outer_radius, ring.length)) for ring in wheelset.rings]
    for side in (-1, 1):
        web = (wheel.web_thickness_hub + wheel.web_thickness_rim) / 2
        parts = [
            _disc(rho, 0.094, wheel.hub_radius, wheel.hub_outer - wheel.hub_inner),
            _disc(rho, wheel.hub_radius, wheel.rim_radius, web),
            _disc(rho, wheel.rim_radius, wheel.rolling_radius, wheel.rim_outer - wheel.rim_inner),
        ]
        bodies.append((side * wheel.web, *np.sum(parts, axis=0)))
        bodies.append((side * wheelset.axle_boxes.distance, wheelset.axle_boxes.mass, 0.0))
    nodes = np.unique(np.round([*ends, *np.linspace(ends[0], ends[-1], 45), *(body[0] for body in bodies)], 9))
    stiffness, mass = (np.zeros((2 * len(nodes), 2 * len(nodes))) for _ in range(2))
    for element, (low, high) in enumerate(pairwise(nodes)):
        section = wheelset.axle.sections[np.searchsorted(ends[1:], (low + high) / 2)]
        area, second = np.pi * section.diameter**2 / 4, np.pi * section.diameter**4 / 64
        beam = Beam(steel.youngs_modulus, steel.poissons_ratio, rho, 0.9, area, second)
        k, m = element_matrices(beam, high - low)
        place = slice(2 * element, 2 * element + 4)
        stiffness[place, place] += k
        mass[place, place] += m
    for y, weight, inertia in bodies:
        node = int(np.abs(nodes - y).argmin())
        mass[2 * node, 2 * node] += weight
        mass[2 * node + 1, 2 * node + 1] += inertia
    values = eigh(stiffness, mass, eigvals_only=True)
    return float(np.sqrt(values[2]) / (2 * np.pi))


def _disc(density: float, inner: float, outer: float, length: float) -> tuple[float, float]:
    """Mass, and moment of inertia about a diameter."""
    mass = density * np.pi * (outer**2 - inner**2) * length
    return mass, mass * (outer**2 + inner**2) / 4 + mass * length**2 / 12


@pytest.mark.slow
def test_mirrored_scenario_gives_mirrored_results() -> None:
    scenario = load_scenario("trailer", ["output.stress_nodes=[A1, A2, B1, B2]"])
    (breakout,) = scenario.irregularities
    simulator = Simulator(scenario)
    mirrored = replace(scenario, irregularities=(replace(breakout, on="wheel_2"),))
    one = simulator.advance(2500)
    other = Simulator(mirrored, models=simulator.models).advance(2500)
    assert one.forces.max() > 1.5 * scenario.wheel_load
    assert one.forces == pytest.approx(other.forces[:, ::-1], rel=1e-4, abs=50.0)
    assert one.stresses == pytest.approx(MIRRORED * other.stresses[:, [1, 0, 3, 2]], rel=1e-4, abs=2e4)
