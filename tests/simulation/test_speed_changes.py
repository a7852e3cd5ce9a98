"""Runs through changes of speed."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from support.advancing import advance_to
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import SetPoint, load_scenario
from wheelset_track_sim.simulation.changes import Revision
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.simulation.speed import LEVEL

BAY = 600
STATIC = 98.1e3


def joined(blocks: list[SampleBlock]) -> np.ndarray:
    return np.concatenate([block.forces for block in blocks])


def change(simulator: Simulator, **values: object) -> Revision:
    return simulator.apply(dataclasses.replace(simulator.scenario, **values))  # type: ignore[arg-type]


def eventful(chunk: int) -> list[SampleBlock]:
    """A ramp; another set point, load and damage on the way."""
    simulator = Simulator(load_scenario("damage_wheel_1", ["acceleration=10"]))
    blocks = advance_to(simulator, 1000, chunk)
    assert change(simulator, speed=30.0) == Revision(1, 1000)
    blocks += advance_to(simulator, 3200, chunk)
    assert change(simulator, speed=27.5, axle_load=180e3) == Revision(2, 3200)
    blocks += advance_to(simulator, 4500, chunk)  # the defect is in the patch
    defect = dataclasses.replace(simulator.scenario.irregularities[0], h=0.0005)
    revision = change(simulator, irregularities=(defect,))
    assert 4510 < revision.step < 4600
    return blocks + advance_to(simulator, 7500, chunk)


@pytest.fixture(scope="module")
def whole() -> list[SampleBlock]:
    return eventful(1389)


@pytest.mark.parametrize("chunk", [pytest.param(1, marks=pytest.mark.slow), 32])
@pytest.mark.slow
def test_any_chunk_length_gives_the_same_bits_through_a_ramp(whole: list[SampleBlock], chunk: int) -> None:
    other = eventful(chunk)
    assert np.array_equal(joined(other), joined(whole))
    assert np.array_equal(
        np.concatenate([block.stresses for block in other]), np.concatenate([block.stresses for block in whole])
    )
    for name in ("speed", "revision", "step_period"):
        each = [np.repeat([getattr(b, name) for b in blocks], [len(b) for b in blocks]) for blocks in (whole, other)]
        assert np.array_equal(*each)
    times = [np.concatenate([b.time + np.arange(len(b)) * b.step_period for b in blocks]) for blocks in (whole, other)]
    assert times[1] == pytest.approx(times[0], rel=1e-14)


def test_what_is_worked_out_ahead_changes_no_bit(whole: list[SampleBlock], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wheelset_track_sim.simulation.simulator.AHEAD", 0)
    assert np.array_equal(joined(eventful(1389)), joined(whole))


def test_time_and_position_add_up(whole: list[SampleBlock]) -> None:
    speeds = [block.speed for block in whole]
    assert len(set(speeds)) == 4
    assert speeds[-1] == 27.5
    time = 0.0
    for block in whole:
        assert block.speed * block.step_period == pytest.approx(1e-3, rel=1e-15)
        assert block.position == block.first_step * 1e-3
        assert block.time == pytest.approx(time, rel=1e-12)
        time += len(block) * block.step_period
    assert np.abs(np.diff(speeds)).max() <= LEVEL


def test_an_early_change_meets_the_run_in_the_speed_in_force(whole: list[SampleBlock]) -> None:
    top = max(block.speed for block in whole)
    assert 28.0 < top < 29.0  # 2.2 m at 10 m/s^2 do not lead to 30 m/s
    before, after = next((b, a) for b, a in pairwise(whole) if a.revision == 2 > b.revision)
    assert before.speed == after.speed == top


@pytest.mark.slow
def test_a_ramp_takes_its_time_and_its_way() -> None:
    simulator = Simulator(load_scenario("undamaged", ["speed=20", "acceleration=2"]))
    change(simulator, speed=24.0)
    while simulator.speed < 24.0:
        simulator.advance(10**5)
    assert simulator.next_step * 1e-3 == pytest.approx((23.75**2 - 20**2) / 4, abs=1e-3)
    assert simulator.time == pytest.approx(3.75 / 2, abs=5e-3)


def test_force_is_continuous_at_a_border() -> None:
    """Against the same run without the change: the difference has no jump where the speed has one."""
    smooth, other = (Simulator(load_scenario("undamaged")) for _ in range(2))
    change(smooth, acceleration=10.0, speed=28.2)
    first, last = (stretch.step for stretch in _known(smooth)[1:])
    other.advance(1)
    ramp, constant = joined(advance_to(smooth, last + 600)), joined(advance_to(other, last + 600))
    first -= 1  # a row
    apart = np.abs(ramp - constant).max(axis=1)
    assert np.array_equal(ramp[: first + 1], constant[: first + 1])  # the force at the border is that of the way there
    assert 0 < apart[first + 1] < 2e-5 * STATIC
    assert np.abs(np.diff(ramp - constant, axis=0))[first : first + 4].max() < 3e-5 * STATIC
    assert apart.max() > 50.0  # another speed it is


def _known(simulator: Simulator) -> tuple:
    simulator.advance(1)
    return simulator.course.stretches


@pytest.mark.slow
def test_a_plateau_equals_the_run_at_constant_speed() -> None:
    changed = Simulator(load_scenario("undamaged", ["speed=27", "acceleration=10"]))
    change(changed, speed=25.0)
    constant = Simulator(load_scenario("undamaged", ["speed=25"]))
    ends = []
    for simulator in (changed, constant):
        advance_to(simulator, 120 * BAY)
        ends.append(simulator.advance(BAY).forces)
    assert np.abs(ends[0] - ends[1]).max() < 20.0


def test_a_plan_is_followed_and_ended_by_a_change_of_speed() -> None:
    plan = (SetPoint(0.01, 28.5), SetPoint(0.2, 20.0))
    simulator = Simulator(dataclasses.replace(load_scenario("undamaged"), acceleration=5.0, speed_plan=plan))
    blocks = advance_to(simulator, 3000)
    start = next(block for block in blocks if block.time >= 0.01)
    assert 0.01 <= start.time < 0.01 + start.step_period
    change(simulator, axle_load=180e3)  # nothing to do with the speed: the plan goes on
    assert {stretch.set_point for stretch in _known(simulator)} == {27.7777778, 28.5, 20.0}
    change(simulator, acceleration=2.0)
    assert {stretch.set_point for stretch in _known(simulator)} == {28.5, 20.0}
    change(simulator, speed=29.0)
    assert {stretch.set_point for stretch in _known(simulator)} == {29.0}
    assert simulator.scenario.speed_plan == ()
    change(simulator, axle_load=190e3, speed_plan=plan)  # of the scenario file again: it stays ended
    assert {stretch.set_point for stretch in _known(simulator)} == {29.0}
    with pytest.raises(InputError, match="speed_plan cannot change"):
        change(simulator, speed_plan=plan[:1])


def test_a_plan_can_be_ended_at_the_speed_of_the_scenario() -> None:
    plan = (SetPoint(0.0, 40.0),)
    simulator = Simulator(dataclasses.replace(load_scenario("undamaged"), acceleration=10.0, speed_plan=plan))
    advance_to(simulator, 3000)
    assert simulator.speed > 28.5
    change(simulator, speed_plan=())
    assert _known(simulator)[-1].speed == simulator.scenario.speed


def test_paper_dynamics_keep_their_speed() -> None:
    with pytest.raises(InputError, match="speed_plan cannot be followed in paper dynamics"):
        load_scenario("undamaged", ["dynamics=paper", "speed_plan=[{time: 1, speed: 30}]"])


@pytest.mark.slow
def test_paper_dynamics_keep_their_speed_while_they_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wheelset_track_sim.simulation.settling.SETTLING", 0.02)
    simulator = Simulator(load_scenario("undamaged", ["dynamics=paper", "speed=25"]))
    with pytest.raises(InputError, match="speed cannot change in paper dynamics"):
        change(simulator, speed=30.0)
    change(simulator, acceleration=1.0)
    assert len(simulator.advance(100)) == 100
    with pytest.raises(InputError, match=r"paper dynamics runs for .* s at most: use causal for longer"):
        simulator.require(round(20.0 / simulator.step_period))


@pytest.fixture(scope="module")
def line() -> list[SampleBlock]:
    """40 km/h to 220 km/h and back, in the same number of levels and a quarter of the time."""
    plan = "speed_plan=[{time: 2, speed: 61.1111111}, {time: 33, speed: 11.1111111}]"
    simulator = Simulator(load_scenario("line_speeds", ["acceleration=2", plan]))
    blocks = []
    while simulator.time < 65.0:
        blocks.append(simulator.advance(10**5))
    assert {40.0, 220.0} <= {round(3.6 * block.speed, 3) for block in blocks}
    return blocks


def steady(speed: float) -> np.ndarray:
    """Forces over two bays in steady running, from a sleeper on."""
    simulator = Simulator(load_scenario("undamaged", [f"speed={speed}"]))
    advance_to(simulator, round(8e3 * speed) // BAY * BAY)
    return simulator.advance(2 * BAY).forces


@pytest.mark.slow
def test_force_is_continuous_from_40_to_220_and_back(line: list[SampleBlock]) -> None:
    """The shape of the force over a bay changes smoothly: no border stands out from the same place a bay before."""
    force = joined(line)
    borders = np.array([after.first_step for before, after in pairwise(line) if after.speed != before.speed])
    assert len(borders) == 2 * 101
    kinks = np.diff(force, n=2, axis=0)  # [k] is at step k + 1; a jump at n shows at n - 1 and n
    for offset in (-2, -1, 0):
        assert np.abs(kinks[borders + offset] - kinks[borders + offset - BAY]).max() < 2e-4 * STATIC
    # The largest change from step to step is that of the wheel above a sleeper, at every speed that is run at.
    largest = max(np.abs(np.diff(steady(speed), axis=0)).max() for speed in np.arange(11.0, 62.0, 3.0))
    assert np.abs(np.diff(force, axis=0)).max() < 1.5 * largest


@pytest.mark.slow
@pytest.mark.parametrize("kmh", [40, 220])
def test_plateaus_are_those_of_constant_speed(line: list[SampleBlock], kmh: int) -> None:
    """4 s after a ramp what is left of it is 1 N at most: the track has forgotten it, the suspension nearly."""
    force, speed = joined(line), next(block.speed for block in line if round(3.6 * block.speed, 3) == kmh)
    reached = [after.first_step for before, after in pairwise(line) if after.speed == speed != before.speed]
    constant = steady(speed)[:BAY]
    for step in reached:
        first = -(-(step + round(4e3 * speed)) // BAY) * BAY
        assert np.abs(force[first : first + BAY] - constant).max() < 1.0
        assert np.ptp(constant) > 1e3
    assert len(reached) == 1
