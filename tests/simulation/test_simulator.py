import dataclasses

import numpy as np
import pytest

from support.advancing import advance_to
from support.toy import toy_scenario, toy_simulator
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import Profiles, load_scenario
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.track.track import load_track


@pytest.mark.parametrize("chunk", [1, 32])
def test_any_chunk_length_gives_the_same_bits(chunk: int) -> None:
    one, two = (Simulator(load_scenario("damage_wheel_1")) for _ in range(2))
    reference, other = advance_to(one, 2 * 1389), advance_to(two, 2 * 1389, chunk)
    for name in ("forces", "stresses"):
        expected = np.concatenate([getattr(block, name) for block in reference])
        assert np.array_equal(np.concatenate([getattr(block, name) for block in other]), expected)
    assert expected.std() > 0


def test_blocks_follow_without_gap(damaged: Simulator) -> None:
    blocks = [damaged.advance(count) for count in (5, 1, 700)]
    assert [block.first_step for block in blocks] == [0, 5, 6]
    assert blocks[2].time == 6 * damaged.step_period
    assert blocks[2].position == pytest.approx(6e-3)
    assert not blocks[0].forces.flags.writeable
    assert blocks[0].stresses.shape == (5, 3, 6)


def test_contact_is_lost_and_regained() -> None:
    simulator = Simulator(load_scenario("damage_wheel_1"))
    force = np.concatenate([block.forces for block in advance_to(simulator, 2713)])[:, 0]
    lost = np.flatnonzero(force == 0)
    assert len(lost) > 10
    assert np.all(np.diff(lost) < 20)
    assert 1770 < lost[0] < 1830  # the defect is centred on 1.8 m
    assert force[lost[-1] :].max() > 2.5 * 98.1e3
    assert force[:1700].min() > 90e3
    assert force.min() == 0


def test_a_defect_comes_into_force_when_it_is_not_in_the_patch(smooth: Simulator) -> None:
    advance_to(smooth, 1790)
    damaged = toy_scenario(like="damage_wheel_1")
    revision = smooth.apply(damaged)
    assert revision.number == 1
    assert 1830 < revision.step < 1900
    before = smooth.advance(1000)
    assert before.revision == 0
    assert before.first_step + len(before) == revision.step
    after = smooth.advance(10)
    assert (after.revision, after.first_step) == (1, revision.step)
    assert smooth.in_force == damaged
    second = np.concatenate([block.forces for block in advance_to(smooth, 1800 + 2713 + 100)])[:, 0]
    assert second.min() == 0


def test_changes_in_a_row_keep_their_order(smooth: Simulator) -> None:
    first = smooth.apply(dataclasses.replace(smooth.scenario, axle_load=190e3))
    second = smooth.apply(dataclasses.replace(smooth.scenario, speed=30.0))
    assert (first.number, second.number) == (1, 2)
    assert smooth.scenario.axle_load == 190e3
    assert smooth.scenario.speed == 30.0
    block = smooth.advance(10)
    assert (block.revision, smooth.course.at(block.first_step).set_point) == (2, 30.0)


@pytest.mark.parametrize(
    "change", [{"track": load_track("slab_60e1")}, {"step_length": 5e-4}, {"profiles": Profiles(inclination=0.025)}]
)
def test_what_cannot_change_is_refused_and_the_run_goes_on(smooth: Simulator, change: dict[str, object]) -> None:
    expected = toy_simulator().advance(20).forces
    with pytest.raises(InputError, match=f"{next(iter(change))} cannot change"):
        smooth.apply(dataclasses.replace(smooth.scenario, **change))  # type: ignore[arg-type]
    assert smooth.revision == 0
    assert np.array_equal(smooth.advance(20).forces, expected)


def test_the_mean_force_is_the_static_load(damaged: Simulator) -> None:
    turns = 40  # momentum: whatever happens in between, the suspension carries the static load
    force = np.concatenate([block.forces for block in advance_to(damaged, turns * 2713)])[10 * 2713 :]
    assert force.mean(axis=0) == pytest.approx([98.1e3, 98.1e3], rel=5e-3)


def test_a_stress_node_that_is_named_twice_is_refused() -> None:
    with pytest.raises(InputError, match=r"^output\.stress_nodes names A1 twice: give each stress node once"):
        load_scenario("undamaged", ["output.stress_nodes=[A1, B1, A1]"])


@pytest.mark.slow
def test_a_smooth_wheel_runs_smoothly_at_low_speed() -> None:
    """Modes above half the sampling rate once fed the contact through their aliases, at some of these speeds."""
    models = None
    for speed in (5.0, 6.0, 7.3, 9.75, 10.0, 10.5, 10.75, 12.0, 14.0):
        simulator = Simulator(load_scenario("undamaged", [f"speed={speed}"]), models=models)
        models = simulator.models
        forces = simulator.advance(4 * simulator.steps_per_revolution).forces
        assert np.abs(forces - 98.1e3).max() < 2e3, speed  # the sleepers' ripple is 1 kN at 14 m/s


def test_a_settled_state_is_kept_and_started_from_again(smooth: Simulator) -> None:
    settled = smooth.settle()
    expected = [smooth.advance(500).forces for _ in range(3)]
    for _ in range(2):  # a run from it leaves it as it is
        again = Simulator(smooth.in_force, models=smooth.models)
        assert again.next_step == 0
        assert again.settle(settled) is settled
        assert all(np.array_equal(again.advance(500).forces, forces) for forces in expected)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rough_wheel", "flat_fresh"])
def test_a_settled_state_on_surfaces_is_started_from_again(name: str) -> None:
    first = Simulator(load_scenario(name))
    settled = first.settle()
    expected = [first.advance(500).forces for _ in range(3)]
    again = Simulator(first.in_force, models=first.models)
    again.settle(settled)
    assert all(np.array_equal(again.advance(500).forces, forces) for forces in expected)


def test_a_branch_goes_on_by_itself() -> None:
    run = toy_simulator()
    run.advance(300)
    branch = run.branch()
    branch.apply(dataclasses.replace(branch.scenario, axle_load=150e3))
    loaded = [branch.advance(500).forces for _ in range(2)][1]
    forces, of_branch = run.branch().advance(1000).forces, run.advance(1000).forces
    assert np.array_equal(forces, of_branch)
    assert np.array_equal(forces, np.concatenate([block.forces for block in advance_to(toy_simulator(), 1300)])[300:])
    assert not np.array_equal(loaded, forces[500:])
    assert (run.revision, branch.revision, run.scenario.axle_load) == (0, 1, 196200.0)
    assert toy_simulator().branch().next_step == 0


@pytest.mark.parametrize("name", ["undamaged", "hanging_sleeper"])
def test_treads_differ_from_one_settled_state(name: str) -> None:
    plain = Simulator(load_scenario(name))
    settled = plain.settle()
    changes = ["irregularities=[{type: breakout, on: wheel_1, a: 0.02, b: 0.01, h: 0.001}]", "settle_on=smooth"]
    damaged = load_scenario(name, changes)
    begun = Simulator(damaged, models=plain.models)
    begun.settle(settled)
    assert np.array_equal(begun.advance(2000).forces, Simulator(damaged, models=plain.models).advance(2000).forces)


def test_a_settled_state_of_another_run_is_refused(smooth: Simulator) -> None:
    settled = smooth.settle()
    heavier = Simulator(load_scenario("undamaged", ["axle_load=220e3"]), models=smooth.models)
    with pytest.raises(InputError, match=r"wheel_load = 98100, the run 110000: settle it again"):
        heavier.settle(settled)
    rough = load_scenario("undamaged", ["irregularities=[{type: flat, on: wheel_1, length: 0.05}]"])
    with pytest.raises(InputError, match="of a run on other surfaces: settle it again"):
        Simulator(rough, models=smooth.models).settle(settled)
    with pytest.raises(InputError, match="belongs to other models"):
        Simulator(load_scenario("undamaged")).settle(settled)
    smooth.advance(1)
    with pytest.raises(ValueError, match="the run has begun"):
        smooth.settle()
