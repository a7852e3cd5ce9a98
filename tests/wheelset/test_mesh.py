from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy

from wheelset_track_sim.wheelset.harmonic_elements import solid_mass
from wheelset_track_sim.wheelset.mesh import stress_fillet, surface_radius, wheelset_mesh
from wheelset_track_sim.wheelset.section_mesh import SectionMesh
from wheelset_track_sim.wheelset.wheelset import Wheelset

SIDES = [[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]]


def outline(mesh: SectionMesh) -> np.ndarray:
    """Element sides (count, 3) that belong to one element only."""
    sides = mesh.elements[:, SIDES].reshape(-1, 3)
    _, first, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    assert count.max() <= 2
    return sides[first[count == 1]]


def test_parts_are_joined_without_gaps(x40: Wheelset) -> None:
    mesh = wheelset_mesh(x40)
    corners, times = np.unique(outline(mesh)[:, [0, 2]], return_counts=True)
    assert len(corners)
    assert (times == 2).all()
    # Where blocks do not conform, a middle of one lies on a corner of the other and stays a separate place to stand.
    assert len(np.unique(np.round(mesh.points / 1e-7).astype(int), axis=0)) == len(mesh.points)
    # Euler: corners - sides + elements = 1 - holes; a web, two spacers and a disc enclose no hole in the section.
    sides = np.unique(np.sort(mesh.elements[:, SIDES].reshape(-1, 3), axis=1), axis=0)
    assert len(np.unique(mesh.elements[:, :4])) - len(sides) + len(mesh.elements) == 1


def test_mass_is_that_of_the_drawing(x40: Wheelset) -> None:
    """Rings and cones by Pappus and the axle by quadrature of its profile."""

    def ring(inner: float, outer: float, length: float) -> float:
        return np.pi * (outer**2 - inner**2) * length

    wheel, discs, gearbox = x40.wheel, x40.brake_discs, x40.gearbox
    assert discs is not None
    assert gearbox is not None
    marks = sorted({place for step in x40.axle.steps() for place in (step.edge, step.tangent)})
    ends = [x40.axle.start, *marks, x40.axle.sections[-1].end]
    axle = sum(
        scipy.integrate.quad(lambda y: np.pi * surface_radius(x40, np.array([y]))[0] ** 2, low, high, epsabs=1e-14)[0]
        for low, high in pairwise(ends)
    )
    web = scipy.integrate.quad(
        lambda r: 4 * np.pi * r * wheel.web_half_thickness(r), wheel.hub_radius, wheel.rim_radius
    )[0]
    face = (
        wheel.web_half_thickness((discs.spacer_inner_radius + discs.spacer_outer_radius) / 2) + discs.spacer_thickness
    )
    spacer = scipy.integrate.quad(
        lambda r: 2 * np.pi * r * (face - wheel.web_half_thickness(r)),
        discs.spacer_inner_radius,
        discs.spacer_outer_radius,
    )[0]
    slope = (wheel.flange_top_width - wheel.flange_width) / wheel.flange_height
    flange = scipy.integrate.quad(
        lambda h: 2 * np.pi * (wheel.rolling_radius + h) * (wheel.flange_width + slope * h), 0, wheel.flange_height
    )[0]
    one_wheel = (
        ring(0.096, wheel.hub_radius, wheel.hub_outer - wheel.hub_inner)
        + web
        + ring(wheel.rim_radius, wheel.rolling_radius, wheel.rim_outer - wheel.rim_inner)
        + flange
        + 2 * spacer
        + 2 * ring(discs.inner_radius, discs.outer_radius, discs.thickness)
    )
    volume = axle + 2 * one_wheel + ring(0.098, gearbox.outer_radius, gearbox.length)
    assert solid_mass(wheelset_mesh(x40), x40.material) == pytest.approx(x40.material.density * volume, rel=1e-6)
    assert x40.material.density * ring(0.098, gearbox.outer_radius, gearbox.length) == pytest.approx(200.0, rel=1e-3)


def test_a_bore_takes_its_cylinder(x40: Wheelset) -> None:
    bored = replace(x40, axle=replace(x40.axle, bore=0.06))
    mesh = wheelset_mesh(bored)
    assert mesh.points[:, 1].min() == pytest.approx(0.03)
    volume = np.pi * 0.03**2 * (x40.axle.sections[-1].end - x40.axle.start)
    lighter = solid_mass(wheelset_mesh(x40), x40.material) - solid_mass(mesh, x40.material)
    assert lighter == pytest.approx(x40.material.density * volume, rel=1e-6)
    for node in x40.stress_nodes:
        assert np.isin(mesh.nodes_on(stress_fillet(x40, node)), np.unique(outline(mesh))).all()


def test_stress_fillets_are_on_the_mesh(x40: Wheelset) -> None:
    for size in (x40.mesh, x40.mesh.divided(2)):
        mesh = wheelset_mesh(x40, size)
        on_surface = np.unique(outline(mesh))
        for node in x40.stress_nodes:
            assert np.isin(mesh.nodes_on(stress_fillet(x40, node, size)), on_surface).all()


def test_a_trailer_wheelset_is_symmetric(x40: Wheelset) -> None:
    seats = {"gearbox_seat": 0.180, "body_2": 0.180}
    sections = tuple(replace(part, diameter=seats.get(part.name, part.diameter)) for part in x40.axle.sections)
    trailer = replace(
        x40,
        axle=replace(x40.axle, sections=sections),
        gearbox=None,
        brake_discs=None,
        stress_nodes=tuple(node for node in x40.stress_nodes if node.name != "B1"),
    )
    mesh = wheelset_mesh(trailer)
    left = solid_mass(SectionMesh(mesh.points, mesh.elements[_middle(mesh) > 0]), x40.material)
    right = solid_mass(SectionMesh(mesh.points, mesh.elements[_middle(mesh) < 0]), x40.material)
    total = solid_mass(mesh, x40.material)
    crossing = np.abs(_middle(mesh)) < x40.mesh.axle
    assert total < 1200.0
    assert left == pytest.approx(right, rel=0.01 + crossing.mean())


def _middle(mesh: SectionMesh) -> np.ndarray:
    middles: np.ndarray = mesh.points[mesh.elements, 0].mean(axis=1)
    return middles
