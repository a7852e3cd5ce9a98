"""Changes of the axle load: the contact bears the new load in the end, and nothing else than that on the way."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.preload import RISE, Loading
from wheelset_track_sim.simulation.simulator import Simulator

LOAD = load_scenario("undamaged").axle_load


@pytest.fixture(scope="module")
def models():
    return Simulator(load_scenario("undamaged")).models


def forces(simulator, time, chunk=1389):
    """Contact forces from now on to a time, and their times."""
    found, times = [], []
    while simulator.time < time:
        block = simulator.advance(chunk)
        found.append(block.forces)
        times.append(block.time + np.arange(len(block)) * block.step_period)
    return np.concatenate(found), np.concatenate(times)


def change(simulator, **values):
    return simulator.apply(dataclasses.replace(simulator.scenario, **values))


def ripple(models, load):
    """Half the ripple of the force at the sleepers under a load, N."""
    found, _ = forces(Simulator(load_scenario("undamaged", [f"axle_load={load} N"]), models=models), 0.1)
    return np.ptp(found) / 2


@pytest.mark.parametrize("load", [400e3, 250e3, 200e3, 20e3])
def test_the_force_follows_the_load_and_ends_as_if_it_had_always_been_there(models, load):
    simulator = Simulator(load_scenario("undamaged"), models=models)
    forces(simulator, 0.2)
    change(simulator, axle_load=load)
    begin = simulator.time
    found, times = forces(simulator, begin + RISE + 1.0)
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip((times - begin) / RISE, 0, 1))
    wanted = (LOAD + (load - LOAD) * share) / 2
    allowed = max(ripple(models, load), ripple(models, LOAD)) + 0.01 * abs(load - LOAD) / 2
    assert np.abs(found - wanted[:, np.newaxis]).max() < 1.1 * allowed
    always = Simulator(load_scenario("undamaged", [f"axle_load={load} N"]), models=models)
    expected, _ = forces(always, times[-1])
    np.testing.assert_allclose(found[-5000:], expected[-5000:], atol=2e-4 * load / 2)


def test_load_on_load_off_again_and_all_at_once(models):
    """Changes while earlier ones are under way add up: no jump, no loss of contact."""
    simulator = Simulator(load_scenario("undamaged"), models=models)
    found = []
    for load in (250e3, 150e3, 300e3, 160e3, 240e3, LOAD):
        change(simulator, axle_load=load)
        found.append(forces(simulator, simulator.time + 0.15)[0])
    end, _ = forces(simulator, simulator.time + RISE + 0.8)
    whole = np.concatenate([*found, end])
    assert np.abs(np.diff(whole, axis=0)).max() < 400  # from step to step; the ripple itself has 200
    assert whole.min() > 70e3
    assert end[-4800:].mean() == pytest.approx(LOAD / 2, rel=1e-3)  # over eight sleeper bays


@pytest.mark.slow
def test_any_chunk_length_gives_the_same_bits(models):
    def run(chunk):
        simulator = Simulator(load_scenario("undamaged", ["acceleration=10"]), models=models)
        parts = [forces(simulator, 0.05, 139)[0]]
        for values in ({"axle_load": 220e3}, {"speed": 29.0}, {"axle_load": 180e3, "speed": 27.0}):
            stop = simulator.next_step + 2780
            change(simulator, **values)
            while simulator.next_step < stop:
                parts.append(simulator.advance(min(chunk, stop - simulator.next_step)).forces)
        while simulator.next_step < 50_000:
            parts.append(simulator.advance(min(chunk, 50_000 - simulator.next_step)).forces)
        return np.concatenate(parts)

    whole = run(1389)
    np.testing.assert_array_equal(run(97), whole)
    np.testing.assert_array_equal(run(5000), whole)


def test_the_pressure_of_a_step_on_the_way_bears_its_force(models):
    simulator = Simulator(load_scenario("undamaged"), models=models)
    change(simulator, axle_load=300e3)
    forces(simulator, 0.5)
    block = simulator.advance(500)
    assert simulator.contact_patch(0, 250).force == pytest.approx(block.forces[250, 0], rel=1e-6)
    assert 1.2 * LOAD < 2 * block.forces[250, 0] < 280e3


def test_changes_that_are_over_are_settled_without_a_change_of_bits():
    first = np.array([0.05, 0.0501])
    loading = Loading(first).changed(0.0, first + 0.013).changed(0.4, first - 0.011).changed(0.7, first - 0.011)
    assert len(loading.changes) == 2  # the third is none
    times = np.linspace(1.0, 2.0, 77)
    settled = loading.over(1.0)
    assert len(settled.changes) == 1
    np.testing.assert_array_equal(settled.at(times), loading.at(times))
    assert settled.over(1.39) is settled
    np.testing.assert_allclose(settled.over(1.5).at(times[-1:]), [first - 0.011], rtol=1e-15)
    assert settled.over(1.5).changes == ()


def test_a_load_on_a_bogie_rises_a_little_later_and_comes_to_rest() -> None:
    """The frame moves by 20 mm within the second: its inertia takes 7 % of the change meanwhile."""
    scenario = load_scenario("undamaged", ["vehicle=power_car"])
    simulator = Simulator(scenario)
    simulator.settle()
    change(simulator, axle_load=LOAD + 40e3)
    found, times = forces(simulator, 2.5, chunk=1800)
    mean = found[: len(found) // 1800 * 1800, 0].reshape(-1, 1800).mean(axis=1)  # of three bays
    middle = times[900::1800][: len(mean)]
    share = 0.5 - 0.5 * np.cos(np.pi * np.clip(middle / RISE, 0.0, 1.0))
    assert np.abs(mean - (LOAD / 2 + 20e3 * share)).max() < 0.08 * 20e3
    assert mean.max() < LOAD / 2 + 1.005 * 20e3
    assert mean[-1] == pytest.approx(LOAD / 2 + 20e3, rel=1e-3)


def test_a_load_on_a_car_body_that_moves_is_refused() -> None:
    scenario = load_scenario("undamaged", ["vehicle=power_car", "vehicle.body_mass=7420"])
    simulator = Simulator(scenario)
    with pytest.raises(InputError, match=r"^axle_load cannot change during a run with vehicle\.body_mass"):
        change(simulator, axle_load=LOAD + 40e3)
    assert change(simulator, speed=30.0).number == 1
