"""Stress nodes anywhere on the axle's surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.mesh import surface_radius, wheelset_mesh
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.stress_node import StressNode
from wheelset_track_sim.wheelset.stress_points import around_axle, on_axle
from wheelset_track_sim.wheelset.wheelset import Wheelset

LOAD = 98.1e3
ANGLES = {"T": 0.0, "F": np.pi / 2, "B": np.pi, "S": 0.7}


def with_nodes(wheelset: Wheelset, *nodes: StressNode) -> Wheelset:
    return replace(wheelset, stress_nodes=nodes)


@pytest.fixture(scope="module")
def around(x40: Wheelset) -> ReducedWheelset:
    """Nodes around the axle at y = -0.2 m, and one in the fillet of A1 by its place."""
    nodes = [StressNode(name, y=-0.2, angle=angle) for name, angle in ANGLES.items()]
    nodes += [StressNode("A1", after="wheel_seat_1"), StressNode("A1bottom", after="wheel_seat_1", angle=np.pi)]
    coarse = replace(x40, mesh=x40.mesh.divided(0.6))
    return build_reduced_wheelset(with_nodes(coarse, *nodes), max_frequency=500.0)


def static(reduced: ReducedWheelset, name: str) -> np.ndarray:
    stress: np.ndarray = reduced.static_stress()[reduced.node(name)].sum(axis=1) * LOAD
    return stress


@pytest.mark.slow
def test_bending_around_the_axle(around: ReducedWheelset) -> None:
    """Between equal wheel loads the moment is constant: sigma = M cos(angle) / W, and nothing else but little shear."""
    bending = LOAD * (1.0275 - 0.750) / (np.pi * 0.180**3 / 32)
    for name, angle in ANGLES.items():
        expected = np.array([0.0, bending * np.cos(angle), 0.0, 0.0, 0.0, 0.0])
        assert static(around, name) == pytest.approx(expected, abs=0.01 * bending)


def test_positions_around_the_axle(around: ReducedWheelset) -> None:
    for name, angle in ANGLES.items():
        place = around.node_positions[around.node(name)]
        assert place == pytest.approx([0.09 * np.sin(angle), -0.2, 0.09 * np.cos(angle)], abs=1e-12)


def test_bottom_of_a_fillet_has_the_place_of_its_top(around: ReducedWheelset) -> None:
    top, bottom = (around.node_positions[around.node(name)] for name in ("A1", "A1bottom"))
    assert bottom == pytest.approx([0.0, top[1], -top[2]], abs=1e-12)
    assert static(around, "A1bottom")[1] == pytest.approx(-static(around, "A1")[1], rel=0.02)


@pytest.mark.slow
def test_a_place_in_a_fillet_is_the_fillets_own(x40: Wheelset, around: ReducedWheelset) -> None:
    """By its y the node of A1 is found again; a little beside it the stress is nearly the same."""
    y = float(around.node_positions[around.node("A1"), 1])
    places = with_nodes(replace(x40, mesh=x40.mesh.divided(0.6)), StressNode("P", y=y), StressNode("Q", y=y + 1e-3))
    reduced = build_reduced_wheelset(places, max_frequency=500.0)
    assert static(reduced, "P") == pytest.approx(static(around, "A1"), rel=1e-3, abs=1e4)
    assert static(reduced, "Q")[1] == pytest.approx(static(around, "A1")[1], rel=0.02)


@given(y=st.floats(-1.109, 1.109))
def test_any_place_is_a_mean_of_mesh_nodes(y: float) -> None:
    side, weights = on_axle(X40, MESH, y)
    assert weights.sum() == pytest.approx(1.0)
    assert weights @ MESH.points[side, 0] == pytest.approx(y, abs=1e-9)
    assert weights @ MESH.points[side, 1] == pytest.approx(surface_radius(X40, np.array([y]))[0], abs=2e-4)


X40 = load_wheelset("x40")
MESH = wheelset_mesh(X40)


@given(angle=st.floats(-7.0, 7.0))
def test_a_uniform_stress_is_the_same_at_every_angle(angle: float) -> None:
    """zz everywhere: n = 0 and 2 in polar components; yz shear: n = 1."""
    vertical = {0: [0.5, 0, 0.5, 0, 0, 0], 2: [0.5, 0, -0.5, 0, -0.5, 0]}
    found = sum(around_axle(n, angle) @ np.array(amplitudes) for n, amplitudes in vertical.items())
    assert found == pytest.approx([0, 0, 1, 0, 0, 0], abs=1e-12)
    shear = around_axle(1, angle) @ np.array([0, 0, 0, -1.0, 0, 1.0])
    assert shear == pytest.approx([0, 0, 0, 0, 0, 1], abs=1e-12)


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ({"name": "D", "y": 1.2}, r"stress_nodes.D.y = 1.2 m is not on the axle: give -1.11 to 1.11 m"),
        ({"name": "D", "y": 0.4}, r"stress_nodes.D.y = 0.4 m is under gearbox, 0.2955 to 0.5105 m"),
        ({"name": "D", "y": -0.7}, r"is under the hub of wheel 1"),
        ({"name": "D", "y": float("nan")}, r"stress_nodes.D.y = nan is not finite"),
        ({"name": "D"}, r"stress node D needs its fillet or its position: give one of after and y"),
        ({"name": "D", "y": 0.0, "after": "body_1"}, r"give one of after and y"),
        ({"name": "D", "y": 0.0, "angle": 10.0}, r"angle = 10 rad is out of range"),
        ({"name": "D 1", "y": 0.0}, r"stress node 'D 1' cannot name a topic"),
        ({"name": "1D", "y": 0.0}, r"a letter first"),
        ({"name": "D__1", "y": 0.0}, r"single underscores"),
        ({"name": "a1", "y": 0.0}, r"stress_nodes has names A1, a1: give each a name of its own, also in lower case"),
    ],
)
def test_bad_nodes_are_refused(x40: Wheelset, node: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message) as refusal:
        with_nodes(x40, StressNode("A1", after="wheel_seat_1"), StressNode(**node))  # type: ignore[arg-type]
    assert "\n" not in str(refusal.value)
