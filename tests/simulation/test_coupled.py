"""The coupled step where tables end, and where there are none."""

from dataclasses import replace

import numpy as np
import pytest

from wheelset_track_sim.contact import approach_for_force, build_contact_law
from wheelset_track_sim.contact.law_kernels import total_separation
from wheelset_track_sim.irregularities import Roughness
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.changes import Condition, Revision
from wheelset_track_sim.simulation.coupled import Coupled
from wheelset_track_sim.simulation.models import load_models, with_own_state

RAIL_STEPS = 1200


@pytest.fixture(scope="module")
def models():
    return load_models(load_scenario("undamaged"))


def rough(models, level):
    dx, turn = models.step_length, models.steps_per_revolution
    surfaces = ("wheel_1", "wheel_2", "rail_1", "rail_2")
    shapes = [Roughness(on, seed=seed, level=level) for seed, on in enumerate(surfaces)]
    return build_contact_law(shapes, models.geometry, dx, turn, rail_steps=RAIL_STEPS)


def run(models, law, chunk, steps=400, raised=1.0):
    """Forces of a run whose static load is ``raised`` above that of steady running."""
    scenario = load_scenario("undamaged")
    load, speed = scenario.wheel_load, scenario.speed
    preload = models.dynamics.preload(load, scenario.step_length, speed)
    preload = preload + approach_for_force(models.contact_law(()), 0, 0, 0, raised * load)
    coupled = Coupled(models, load, 0, speed)
    condition = Condition(Revision(0, 0), scenario, with_own_state(law), preload, 0, models.tread_origin)
    found = []
    while coupled.next_step < steps:
        count = min(chunk, steps - coupled.next_step)
        found.append(coupled.run(condition, speed, np.tile(preload, (count, 1)))[0])
    return np.concatenate(found)


@pytest.mark.slow
def test_roughness_and_no_bit_by_length_of_chunks(models):
    law = rough(models, 3.0)
    assert (law.table == -1).all()
    whole = run(models, law, 400)
    assert 1e3 < np.ptp(whole[100:, 0]) < 60e3
    assert not np.allclose(whole[:, 0], whole[:, 1], atol=100.0)
    for chunk in (1, 32, 137):
        assert (run(models, law, chunk) == whole).all()


def test_roughness_of_little_height_is_smooth_running(models):
    smooth = run(models, models.contact_law(()), 400)
    assert np.abs(run(models, rough(models, -60.0), 400) - smooth).max() < 0.01 * 98.1e3


@pytest.mark.parametrize("chunk", [400, 32])
def test_beyond_the_tables_steps_are_solved_and_the_run_goes_on(models, chunk):
    """Tables cut off at a force that the run crosses back and forth give the bits of tables and solver by turns."""
    law = models.contact_law(())
    whole = run(models, law, chunk, raised=1.3)
    limit = float(np.median(whole))
    first, end = law.first_point[:2]
    kept = int(np.searchsorted(law.points[first:end, 1], limit))
    cut = law._replace(first_point=np.array([0, kept]), points=law.points[:kept].copy())
    found = run(models, cut, chunk, raised=1.3)
    assert (found[whole > law.points[kept, 1]] > limit).all()
    np.testing.assert_allclose(found, whole, rtol=1e-8)
    assert 0.2 < (whole > limit).mean() < 0.8


def test_rough_rails_under_smooth_treads(models):
    dx = models.step_length
    shapes = [Roughness("rail_2", seed=1)]
    law = build_contact_law(shapes, models.geometry, dx, models.steps_per_revolution, rail_steps=RAIL_STEPS)
    assert total_separation(law, 0, 5, 7).tolist() == law.separation[0].tolist()
    forces = run(models, law, 400)
    smooth = run(models, models.contact_law(()), 400)
    assert np.abs(forces[:, 1] - smooth[:, 1]).max() > 10 * np.abs(forces[:, 0] - smooth[:, 0]).max() > 0


def test_a_speed_that_changes_where_tables_end_keeps_its_step(models):
    """The one step at which the speed changes has coefficients of its own, whether a table or the solver answers."""
    scenario = load_scenario("undamaged")
    load, speed = scenario.wheel_load, scenario.speed
    preload = models.dynamics.preload(load, scenario.step_length, speed)
    preload = preload + approach_for_force(models.contact_law(()), 0, 0, 0, load)
    law = models.contact_law(())
    found = []
    for each in (law, law._replace(first_point=np.array([0, 2]), points=law.points[:2].copy())):
        coupled = Coupled(models, load, 0, speed)
        condition = Condition(Revision(0, 0), replace(scenario), each, preload, 0, models.tread_origin)
        parts = [coupled.run(condition, v, np.tile(preload, (n, 1)))[0] for v, n in ((speed, 50), (0.9 * speed, 60))]
        found.append(np.concatenate(parts))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-8)
