"""Changes of what never leaves the contact patch."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.contact.solutions import force_at
from wheelset_track_sim.irregularities import Corrugation, Harmonic, Polygon, Roughness
from wheelset_track_sim.scenario.scenario import load_scenario
from wheelset_track_sim.simulation.handover import FADE, Handover, handover
from wheelset_track_sim.simulation.models import load_models
from wheelset_track_sim.simulation.preload import Loading
from wheelset_track_sim.simulation.simulator import Simulator


@pytest.fixture(scope="module")
def models():
    return load_models(load_scenario("undamaged"), tables="smooth")


def polygons(amplitude):
    return tuple(Polygon(on, (Harmonic(3, amplitude), Harmonic(11, amplitude / 5))) for on in ("wheel_1", "wheel_2"))


ROUGH = tuple(Roughness(on, seed=seed, level=-3.0) for seed, on in enumerate(("wheel_1", "rail_1", "rail_2")))


def advanced(simulator, steps, chunk=700):
    blocks = []
    while sum(map(len, blocks)) < steps:
        blocks.append(simulator.advance(min(chunk, steps - sum(map(len, blocks)))))
    return blocks


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (polygons(1e-4), polygons(3e-4)),
        (polygons(2e-4), ()),
        pytest.param((), ROUGH, marks=pytest.mark.slow),
        pytest.param(
            ROUGH,
            (Roughness("wheel_1", seed=9), Corrugation("rail_1", wavelength=0.045, amplitude=2e-5)),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["polygon grows", "polygon goes", "roughness comes", "roughness becomes another"],
)
def test_the_force_goes_on_without_a_jump(models, before, after):
    scenario = dataclasses.replace(load_scenario("undamaged"), irregularities=before)
    simulator = Simulator(scenario, models=models)
    advanced(simulator, 4000)
    revision = simulator.apply(dataclasses.replace(scenario, irregularities=after))
    assert 4000 <= revision.step < 4000 + models.steps_per_revolution
    forces = np.concatenate([block.forces for block in advanced(simulator, 6000)])
    at = revision.step - 4000
    steps = np.abs(np.diff(forces, axis=0))
    # From one step to the next the force changes there as it does elsewhere, of either irregularity.
    elsewhere = np.maximum(steps[: at - 50].max(axis=0), steps[at + 50 :].max(axis=0))
    assert (steps[at - 5 : at + 5].max(axis=0) <= 1.2 * elsewhere + 100.0).all()
    assert (np.abs(forces[at : at + 400] - 98.1e3).max(axis=0) < 60e3).all()


def raised(one, other, forces):
    return handover(one, other, 2345, 1800, np.asarray(forces), time=2.0, step_period=4e-5)


@pytest.mark.slow
def test_the_approach_is_raised_by_what_keeps_the_force(models):
    one, other = models.contact_law(ROUGH), models.contact_law(polygons(3e-4))
    assert np.abs(raised(one, other, [90e3, 110e3]).by).max() > 1e-5
    for wheel in (0, 1):
        approach = 1.0e-4
        force = force_at(one, wheel, 545, 2345, approach)
        own = raised(one, other, [force, force]).by[wheel]
        assert force_at(other, wheel, 545, 2345, approach + own) == pytest.approx(force, rel=1e-6)
    # Where a wheel is off the rail, its distance is kept.
    assert np.isfinite(raised(one, other, [0.0, 0.0]).by).all()
    assert not np.any(raised(one, one, [90e3, 110e3])[1:])


def test_the_rate_is_that_of_the_heights(models):
    smooth, other = models.contact_law(()), models.contact_law(polygons(3e-4))
    found = raised(smooth, other, [98e3, 98e3])
    heights = other.tread[0, 545 + np.array([-8, 0, 8]), 20]
    assert found.by == pytest.approx(-heights[1], abs=1e-6)
    # Besides, the point of contact wanders with the slope: R h'^2 / 2.
    assert found.rate == pytest.approx(-(heights[2] - heights[0]) / (16 * 4e-5), rel=0.04)


def test_what_was_raised_fades_without_a_kink():
    given = Handover(2.0, np.array([1e-5, 0.0]), np.array([3e-3, 0.0]))
    loading = Loading(np.array([1e-3, 2e-3])).raised(given)
    times = np.linspace(2.0, 2.0 + 2 * FADE, 2001)
    at = loading.at(times)
    assert (at[:, 1] == 2e-3).all()
    assert at[[0, 1000, 2000], 0] - 1e-3 == pytest.approx([1e-5, 0.0, 0.0], abs=1e-18)
    rate = np.gradient(at[:, 0], times)
    assert rate[0] == pytest.approx(3e-3, rel=0.01)
    assert np.abs(np.diff(rate)[1:]).max() < 4e-5
    assert (loading.over(2.0 + FADE).at(times[-1:]) == at[-1]).all()
    assert loading.over(2.0 + 0.9 * FADE) is loading


def test_a_run_begins_with_what_never_leaves_the_patch(models):
    scenario = dataclasses.replace(load_scenario("undamaged"), irregularities=polygons(2e-4))
    simulator = Simulator(scenario, models=models)
    forces = simulator.advance(2713).forces
    smooth = Simulator(load_scenario("undamaged"), models=models).advance(2713).forces
    assert np.abs(forces[0] - smooth[0]).max() < 1e3
    assert np.abs(forces - smooth)[200:].max() > 3e3


@pytest.mark.slow
def test_made_again_at_its_step_a_change_gives_the_same_bits(models):
    scenario = dataclasses.replace(load_scenario("undamaged"), irregularities=polygons(1e-4))
    changed = dataclasses.replace(scenario, irregularities=ROUGH)
    one, two = Simulator(scenario, models=models), Simulator(scenario, models=models)
    advanced(one, 1000)
    revision = one.apply(changed)
    first = np.concatenate([block.forces for block in advanced(one, 4000)])
    assert two.apply(changed, not_before=revision.step, exactly=True) == revision
    again = np.concatenate([block.forces for block in advanced(two, 5000, chunk=777)])
    assert (again[1000:] == first).all()
