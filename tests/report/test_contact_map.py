import numpy as np
import pytest

from wheelset_track_sim.contact import HertzContact
from wheelset_track_sim.report.contact_map import contact_map
from wheelset_track_sim.scenario import load_scenario


def test_the_pressure_bears_the_recorded_force():
    found = contact_map(load_scenario("damage_wheel_1"), 0, 1811, 291e3)
    area = (found.x[1] - found.x[0]) * (found.y[1] - found.y[0])
    assert found.force == pytest.approx(291e3, rel=1e-9)
    assert found.pressure.sum() * area == pytest.approx(291e3, rel=1e-9)


def test_a_smooth_contact_is_that_of_hertz():
    found = contact_map(load_scenario("undamaged"), 1, 5000, 98.1e3)
    hertz = HertzContact(0.43175, 0.3, 210e9 / (1 - 0.3**2) / 2)
    assert found.pressure.max() / 1e6 == pytest.approx(hertz.peak_pressure(98.1e3) / 1e6, rel=0.02)
    assert found.defects == ()


def test_it_is_the_pressure_of_the_simulation():
    from wheelset_track_sim.simulation.simulator import Simulator

    simulator = Simulator(load_scenario("damage_wheel_1"))
    block = simulator.advance(2713)
    step = int(block.forces[:, 0].argmax())
    found = contact_map(simulator.scenario, 0, step, float(block.forces[step, 0]))
    expected = simulator.contact_patch(0, step).pressure
    np.testing.assert_allclose(found.pressure.max(), expected.max(), rtol=1e-9)
    np.testing.assert_allclose(found.pressure.sum(), expected.sum(), rtol=1e-9)
    assert (found.pressure > 0).sum() == (expected > 0).sum()


def test_a_contact_with_a_hardness_is_solved_with_it():
    scenario = load_scenario("flat_fresh", ["contact.hardness=2.6e9"])
    found = contact_map(scenario, 0, 1826, 286e3)
    area = (found.x[1] - found.x[0]) * (found.y[1] - found.y[0])
    assert found.pressure.max() == found.bound == 2.6e9
    assert found.pressure.sum() * area == pytest.approx(286e3, rel=1e-9)


@pytest.mark.parametrize(("turns", "behind"), [(0, 0.011), (3, -0.02)])
def test_defects_lie_where_they_meet_the_rail(turns, behind):
    scenario = load_scenario("damage_wheel_1")
    step = round((scenario.reference_position + behind) / 1e-3) + 2713 * turns
    [(ahead, defect)] = contact_map(scenario, 0, step, 100e3).defects
    assert ahead == pytest.approx(-behind)
    assert defect == scenario.irregularities[0]
    assert contact_map(scenario, 1, step, 100e3).defects == ()  # the other wheel has none
    assert contact_map(scenario, 0, step + 1000, 100e3).defects == ()
