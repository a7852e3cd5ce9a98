from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.wheelset.harmonic_elements import solid_mass
from wheelset_track_sim.wheelset.kinds import load_wheelset, reduce_wheelset
from wheelset_track_sim.wheelset.mesh import wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.section_outline import section_outline
from wheelset_track_sim.wheelset.wheelset import PointMass, Ring, Wheelset


def revolved_volume(outline: np.ndarray) -> float:
    """Volume of a polygon's revolution, by Green: the integral of pi r^2 dy around it, straight sides."""
    (y0, r0), (y1, r1) = outline[:-1].T, outline[1:].T
    return float(abs(np.sum((y1 - y0) * (r0 * r0 + r0 * r1 + r1 * r1)) * np.pi / 3))


def test_outlines_enclose_the_wheelsets_mass(x40: Wheelset, reduced_x40: ReducedWheelset) -> None:
    equipped = replace(
        x40,
        equipment=(
            Ring("disc", y=-0.3, length=0.06, outer_radius=0.3),
            PointMass("sensor", y=-0.1, length=0.05, mass=1.0),
        ),
    )
    outline = section_outline(equipped, reduced_x40)
    assert [*outline.parts] == ["axle", "gearbox", "wheel_1", "wheel_2", "disc"]
    for part in outline.parts.values():
        for closed in part:
            assert np.array_equal(closed[0], closed[-1])
            assert (closed[:, 1] >= 0).all()
    volume = sum(revolved_volume(closed) for part in outline.parts.values() for closed in part)
    mass = solid_mass(wheelset_mesh(equipped), equipped.material)
    assert equipped.material.density * volume == pytest.approx(mass, rel=1e-4)
    assert outline.masses["sensor"] == pytest.approx([-0.125, -0.075, 0.09])
    assert outline.contacts == pytest.approx(np.array([[-0.75, 0.43175], [0.75, 0.43175]]))
    assert outline.node_names == ("A1", "B1", "C1")


def test_an_imported_wheelset_has_nodes_alone() -> None:
    wheelset = load_wheelset("trailer_calculix")
    outline = section_outline(wheelset, reduce_wheelset(wheelset))
    assert outline.parts == {}
    assert outline.node_names == ("A1", "A2", "B1", "B2", "M")
    assert outline.contacts[:, 1] == pytest.approx(0.46)
