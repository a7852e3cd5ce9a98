"""The shipped freight and metro wheelsets: masses, first modes, and nominal stress of plain and bored bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.scenario.loads import Loads
from wheelset_track_sim.simulation.superposition import superposition
from wheelset_track_sim.wheelset.kinds import load_wheelset
from wheelset_track_sim.wheelset.reduced import ReducedWheelset
from wheelset_track_sim.wheelset.reduction import build_reduced_wheelset
from wheelset_track_sim.wheelset.stress_node import StressNode
from wheelset_track_sim.wheelset.wheelset import Wheelset

pytestmark = pytest.mark.slow

Shipped = tuple[Wheelset, ReducedWheelset]


@pytest.fixture(scope="module", params=["freight", "metro"])
def shipped(request: pytest.FixtureRequest) -> Shipped:
    """Coarse, with another stress node on the body, far from everything."""
    wheelset = load_wheelset(request.param)
    nodes = (*wheelset.stress_nodes, StressNode("body", y=-0.2))
    coarse = replace(wheelset, mesh=wheelset.mesh.divided(0.6), stress_nodes=nodes)
    return coarse, build_reduced_wheelset(coarse, max_frequency=250.0)


def test_masses_and_first_modes(shipped: Shipped) -> None:
    """Of the size that such wheelsets have: a ton, bounce and roll of 5 to 12 Hz, first bending of 60 to 90 Hz."""
    wheelset, reduced = shipped
    assert 950.0 < reduced.mass - 2 * wheelset.axle_boxes.mass < 1250.0
    bounce, roll, bending = reduced.frequencies[:3]
    stiffness = 2 * wheelset.axle_boxes.stiffness
    assert bounce == pytest.approx(np.sqrt(stiffness / reduced.mass) / (2 * np.pi), rel=0.02)
    assert bounce < roll < 12.0
    assert 60.0 < bending < 90.0


def test_nominal_stress_of_the_body(shipped: Shipped) -> None:
    """32 P (b - s) / (pi d^3) between the wheels, over 1 - (bore / d)^4."""
    wheelset, reduced = shipped
    section = next(part for part in wheelset.axle.sections if part.end > -0.2)
    lever = wheelset.axle_boxes.distance - wheelset.wheel.contact
    hollow = 1 - (wheelset.axle.bore / section.diameter) ** 4
    nominal = 32 * lever / (np.pi * section.diameter**3 * hollow)
    assert reduced.static_stress()[reduced.node("body"), 1].sum() == pytest.approx(nominal, rel=0.005)


def test_static_stress_of_the_shipped_scenarios(shipped: Shipped) -> None:
    """Below the fatigue limit of an axle of EA1N, 200 MPa, with the loads of the scenario, and lower by own weight."""
    wheelset, reduced = shipped
    scenario = load_scenario(wheelset.name)
    by_contacts = reduced.static_stress().sum(axis=2) * scenario.wheel_load
    assert scenario.loads.own_weight
    for loads, least, most in ((scenario.loads, 50e6, 150e6), (Loads(own_weight=True), 40e6, 80e6)):
        added = superposition(loads, wheelset, reduced, reduced.node_names)
        assert added is not None
        highest = maximum_principal(by_contacts + added.stresses(np.zeros(1)).reshape(-1, 6)).max()
        assert least < highest < most
    assert highest < maximum_principal(by_contacts).max()
