"""Bending by own weight, longitudinal and lateral forces against beams, equilibrium and the other plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.around import Around
from wheelset_track_sim.wheelset.harmonic_elements import nodal_stress, stiffness_and_mass
from wheelset_track_sim.wheelset.harmonics import GRAVITY, contact_displacements, harmonic, total_mass
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import section_blocks, wheelset_mesh
from wheelset_track_sim.wheelset.parts import Axle, AxleSection
from wheelset_track_sim.wheelset.section_mesh import joined
from wheelset_track_sim.wheelset.static_bending import (
    lateral_stress,
    longitudinal_stress,
    own_weight_stress,
    transferred,
)
from wheelset_track_sim.wheelset.stress_points import combined, stress_points, surface_amplitudes
from wheelset_track_sim.wheelset.wheelset import PointMass, Wheelset

RADIUS, BORE = 0.09, 0.035
MODULUS = np.pi * RADIUS**3 / 4
"""Of the section against bending, m^3."""
FAR = np.array([-0.3, 0.0, 0.15, 0.58])
"""y of places on the plain shaft away from hubs and gearbox, m."""
TOP, FRONT, BOTTOM = 0.0, np.pi / 2, np.pi
TOGETHER = np.array([1.0, 1.0])


@pytest.fixture(scope="module")
def plain() -> Wheelset:
    """The X40 on an axle of one diameter."""
    x40 = load_wheelset("x40")
    axle = Axle(start=-1.11, sections=(AxleSection("shaft", end=1.11, diameter=2 * RADIUS),))
    return replace(x40, axle=axle, stress_nodes=())


@pytest.fixture(scope="module")
def bored(plain: Wheelset) -> Wheelset:
    return replace(plain, axle=replace(plain.axle, bore=2 * BORE))


def at(stress: Around, angle: float) -> np.ndarray:
    return stress.at(np.full(len(stress.mean), angle))


def bending_moment(y: np.ndarray, forces: list[tuple[float, float]], support: float) -> np.ndarray:
    """Of a beam on supports at -support and +support: positive where forces (y, N) upwards bow it upwards."""
    left = sum(force * (support - place) / (2 * support) for place, force in forces)
    parts = [force * np.clip(y - place, 0.0, None) for place, force in forces]
    moment: np.ndarray = left * (y + support) - sum(parts, np.zeros_like(y))
    return moment


def bodies(wheelset: Wheelset) -> list[tuple[float, float]]:
    """Places and masses of slices of all parts, by quadrature of the rings that elements are."""
    found = []
    for blocks in section_blocks(wheelset).values():
        mesh = joined(blocks)
        _, mass = stiffness_and_mass(mesh, wheelset.material, 0)
        line = np.zeros(3 * len(mesh.points))
        line[1::3] = 1.0
        found += [*zip(mesh.points[:, 0], (mass @ line)[1::3], strict=True)]
    return found


def test_own_weight_of_the_x40() -> None:
    """Static stresses at 20 t, without and with it; at 12 t they are up to 23 % too high without it."""
    x40 = load_wheelset("x40")
    mesh = wheelset_mesh(x40)
    samples = stress_points(x40, mesh)
    unit = np.zeros((len(samples.nodes), 6))
    for n in range(4):
        model = harmonic(x40, mesh, n)
        stress = samples.turned(n) @ nodal_stress(mesh, x40.material, n, samples.nodes) @ model.free
        unit += (stress @ model.static(model.contacts @ TOGETHER)).reshape(-1, 6)
    picks = samples.picks(unit)
    without = combined(unit, picks) * 98.1e3
    weight = at(own_weight_stress(x40, combined(mesh.points[samples.nodes, 0], picks)), TOP)
    assert maximum_principal(without) / 1e6 == pytest.approx([66.1, 62.5, 60.8], abs=0.06)
    assert maximum_principal(without + weight) / 1e6 == pytest.approx([60.9, 55.6, 55.4], abs=0.06)
    light = 0.6 * without
    excess = maximum_principal(light) / maximum_principal(light + weight) - 1
    assert excess.max() == pytest.approx(0.226, abs=0.003)


def test_weight_and_what_carries_it(plain: Wheelset) -> None:
    """All the mass weighs, and the axle boxes hold it up: W in all, and no moment is left."""
    mesh = wheelset_mesh(plain)
    model = harmonic(plain, mesh, 1)
    weight = model.weight()
    held = -plain.axle_boxes.stiffness * (model.boxes.T @ model.static(weight))
    own = sum(mass for _, mass in bodies(plain))
    assert held.sum() == pytest.approx(GRAVITY * total_mass(plain, mesh), rel=1e-7)
    assert held.sum() == pytest.approx(GRAVITY * (own + 2 * plain.axle_boxes.mass), rel=1e-7)
    lever = sum(place * mass for place, mass in bodies(plain))
    assert held @ [-1, 1] * plain.axle_boxes.distance == pytest.approx(GRAVITY * lever, rel=1e-6)


def test_own_weight_of_a_shaft_with_wheels(plain: Wheelset) -> None:
    """sigma = M / W of a beam that carries wheels, gearbox and itself between the axle boxes."""
    found = own_weight_stress(plain, FAR)
    forces = [(place, -GRAVITY * mass) for place, mass in bodies(plain)]
    expected = -bending_moment(FAR, forces, plain.axle_boxes.distance) / MODULUS
    assert expected.min() > 4e6
    # At y = 0.58 hub and gearbox are 70 mm away.
    assert at(found, TOP)[:, 1] == pytest.approx(-expected, rel=0.02)
    assert at(found, TOP)[:2, 1] == pytest.approx(-expected[:2], rel=0.005)
    assert at(found, BOTTOM)[:, 1] == pytest.approx(expected, rel=0.02)
    assert at(found, FRONT)[:, 1] == pytest.approx(0.0, abs=1e-9 * expected.max())


def test_own_weight_of_a_mass_on_the_shaft(plain: Wheelset) -> None:
    """A mass in the middle adds m g (b - |y|) / 2 to the bending moment; axle boxes of any mass add nothing."""
    mass, boxes = PointMass("motor", y=0.0, length=0.1, mass=500.0), plain.axle_boxes
    heavy = replace(plain, equipment=(mass,), axle_boxes=replace(boxes, mass=boxes.mass + 200.0))
    y = np.array([-0.4, 0.15])
    added = at(own_weight_stress(heavy, y), TOP) - at(own_weight_stress(plain, y), TOP)
    moment = 500.0 * GRAVITY / 2 * (boxes.distance - np.abs(y))
    assert added[:, 1] == pytest.approx(-moment / MODULUS, rel=0.005)


@pytest.mark.parametrize("share", [0.5, 0.2])
def test_longitudinal_forces_bend_the_shaft_forwards(plain: Wheelset, share: float) -> None:
    """Traction: T / R forwards at the wheels and backwards at the axle boxes is tension at the front."""
    found = longitudinal_stress(plain, FAR, share)
    radius, (first, second) = plain.rolling_radius, plain.contact_positions
    forces = [(first, share / radius), (second, (1 - share) / radius)]
    # The moment that bows the axle towards the forces.
    moment = bending_moment(FAR, forces, plain.axle_boxes.distance)
    expected = np.abs(moment) / MODULUS
    assert at(found, FRONT)[:, 1] == pytest.approx(expected, rel=0.02)
    assert at(found, -FRONT)[:, 1] == pytest.approx(-expected, rel=0.02)
    assert at(found, TOP)[:, 1] == pytest.approx(0.0, abs=1e-9 * expected.max())


def test_the_horizontal_plane_is_the_vertical_one_turned(plain: Wheelset) -> None:
    """Forces upwards make at the top what forces forwards make at the front, also in shear, away from the wheels."""
    mesh = wheelset_mesh(plain)
    model = harmonic(plain, mesh, 1)
    y = FAR[:3]
    forwards = longitudinal_stress(plain, y, 0.3)
    upwards = model.free.T @ (contact_displacements(plain, mesh, "up") @ [0.3, 0.7]) / plain.rolling_radius
    vertical = Around.vertical(surface_amplitudes(plain, mesh, 1, model.free @ model.static(upwards), y))
    for angle in (0.0, 0.7, 2.0):
        turned = forwards.polar(np.array([angle + np.pi / 2]))
        assert turned == pytest.approx(vertical.polar(np.array([angle])), abs=0.003 * np.abs(vertical.cosine).max())


def test_lateral_force_bends_the_axle_from_its_wheel_on(plain: Wheelset) -> None:
    """M = Y R at the wheel and, by the rails' vertical forces, none at the other one; and axial force beside it."""
    force, radius, (first, second) = 5e4, plain.rolling_radius, plain.contact_positions
    found = lateral_stress(plain, FAR, np.array([force, 0.0]))
    moment = force * radius * (second - FAR) / (second - first)
    area = np.pi * RADIUS**2
    axial = -force / 2 / area
    assert at(found, TOP)[:, 1] == pytest.approx(moment / MODULUS + axial, rel=0.02)
    assert at(found, BOTTOM)[:, 1] == pytest.approx(-moment / MODULUS + axial, rel=0.02)
    assert at(found, FRONT)[:, 1] == pytest.approx(axial, rel=0.04)
    assert transferred(plain, np.array([force, 0.0])) == pytest.approx(force * radius / 1.5 * np.array([1, -1]))
    mirrored = lateral_stress(plain, FAR, np.array([0.0, -force]))
    moment = force * radius * (FAR - first) / (second - first)
    assert at(mirrored, TOP)[:, 1] == pytest.approx(moment / MODULUS + axial, rel=0.03)


def test_beyond_the_wheels_a_lateral_force_bends_nothing(plain: Wheelset) -> None:
    y = np.array([-0.93, 0.93])
    found = lateral_stress(plain, y, np.array([5e4, 2e4]))
    axial = 3.5e4 / (np.pi * RADIUS**2)
    assert found.mean[:, 1] == pytest.approx([axial, -axial], rel=0.05)
    assert np.abs(found.cosine).max() < 0.02 * axial


def test_a_bore_takes_its_share_of_the_section(plain: Wheelset, bored: Wheelset) -> None:
    """I_bored = pi / 64 (D^4 - d^4), for bending in both planes; the axial force has the area."""
    rest = 1 - (BORE / RADIUS) ** 4
    y = FAR[:3]
    full, less = (longitudinal_stress(wheelset, y, 0.5).sine[:, 1] for wheelset in (plain, bored))
    assert less == pytest.approx(full / rest, rel=0.003)
    forces = np.array([3e4, -1e4])
    full, less = (lateral_stress(wheelset, y, forces) for wheelset in (plain, bored))
    assert less.cosine[:, 1] == pytest.approx(full.cosine[:, 1] / rest, rel=0.003)
    assert less.mean[:, 1] == pytest.approx(full.mean[:, 1] / (1 - (BORE / RADIUS) ** 2), rel=0.01)


def test_own_weight_of_a_bored_shaft(bored: Wheelset) -> None:
    forces = [(place, -GRAVITY * mass) for place, mass in bodies(bored)]
    expected = bending_moment(FAR, forces, bored.axle_boxes.distance) / (MODULUS * (1 - (BORE / RADIUS) ** 4))
    assert at(own_weight_stress(bored, FAR), TOP)[:, 1] == pytest.approx(-np.abs(expected), rel=0.02)
