"""The staircase as a pure function."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from wheelset_track_sim.scenario import SetPoint
from wheelset_track_sim.simulation.speed import FAR, LEVEL, Course, Stretch, levels, ramp

SPEEDS = st.floats(5.0, 100.0)
ACCELERATIONS = st.floats(0.01, 10.0)
LENGTHS = st.sampled_from([2e-4, 1e-3, 2e-3])
KMH = 1 / 3.6


def standing(speed: float, dx: float = 1e-3) -> Course:
    return Course((Stretch(0, 0.0, speed, speed),), dx)


@given(SPEEDS, SPEEDS)
def test_levels_are_monotone_few_and_end_at_the_set_point(speed: float, set_point: float) -> None:
    found = levels(speed, set_point)
    assert (found == []) == (speed == set_point)
    if found:
        steps = np.diff([speed, *found]) * np.sign(set_point - speed)
        assert found[-1] == set_point
        assert (steps > 0).all()
        assert steps.max() <= LEVEL
        assert all(level % LEVEL == 0 for level in found[:-1])


@given(SPEEDS, SPEEDS)
def test_the_way_down_has_the_levels_of_the_way_up(one: float, other: float) -> None:
    assert levels(one, other)[:-1] == levels(other, one)[-2::-1]


@given(SPEEDS, SPEEDS, ACCELERATIONS, LENGTHS, st.integers(0, 10**10))
@example(5.0, math.nextafter(5.0, 6.0), 1.0, 2e-4, 0)  # a way of no length
def test_a_ramp_follows_a_train_of_constant_acceleration(
    speed: float, set_point: float, acceleration: float, dx: float, step: int
) -> None:
    start = Stretch(step, 12.5, speed, set_point)
    found = list(ramp(start, acceleration, dx))
    if speed == set_point:
        assert found == []
        return
    assert found[-1].speed == set_point
    assert all(after.step > before.step for before, after in pairwise([start, *found]))
    sign = math.copysign(1.0, set_point - speed)
    slowest = min(speed, set_point)
    rounding = 2 * acceleration * dx / slowest  # of a border to the next step
    for before, after in pairwise([start, *found]):
        train = math.sqrt(speed**2 + sign * 2 * acceleration * (after.step - step) * dx)
        assert before.speed * sign < after.speed * sign
        for stair in (before, after):
            assert abs(stair.speed - train) <= LEVEL / 2 + rounding
        time = abs(train - speed) / acceleration
        # only the first stretch is off its mean speed, by a quarter of a level at most
        assert after.time - start.time == pytest.approx(time, abs=LEVEL**2 / (4 * acceleration * slowest) + 2 * dx)


@given(SPEEDS, SPEEDS, SPEEDS, ACCELERATIONS, st.floats(0.0, 1.2))
def test_a_new_set_point_begins_with_the_speed_in_force(
    speed: float, first: float, second: float, acceleration: float, share: float
) -> None:
    course = standing(speed).redirected(0, first, acceleration)
    step = round(share * course.stretches[-1].step)
    on, time = course.at(step), course.time_of(step)
    turned = course.redirected(step, second, acceleration)
    assert turned.stretches[0] == Stretch(step, time, on.speed, second)
    assert turned.stretches[-1].speed == turned.stretches[-1].set_point == second
    assert turned.time_of(step + 1) == pytest.approx(course.time_of(step) + 1e-3 / on.speed)


def test_borders_and_times_are_found_from_any_step() -> None:
    course = standing(20.0).redirected(100, 21.2, 0.5)
    assert [stretch.speed for stretch in course.stretches] == [20.0, 20.5, 21.0, 21.2]
    steps = [stretch.step for stretch in course.stretches]
    # the train passes the means
    assert steps == [100, *(100 + math.ceil((mean**2 - 400) / 1e-3) for mean in (20.25, 20.75, 21.1))]
    assert course.border(0) == 100
    assert course.border(steps[1] - 1) == steps[1]
    assert course.border(steps[1]) == steps[2]
    assert course.border(steps[3]) == FAR
    assert course.at(50).speed == course.at(steps[1] - 1).speed == 20.0
    periods = [1e-3 / course.at(step).speed for step in range(steps[3] + 10)]
    assert course.time_of(steps[3] + 10) == pytest.approx(sum(periods), rel=1e-12)


def test_a_plan_is_followed_from_the_first_step_of_its_times_on() -> None:
    plan = (SetPoint(2.0, 61.0), SetPoint(100.0, 20.0), SetPoint(110.0, 40.0), SetPoint(400.0, 40.0))
    course = standing(40 * KMH).redirected(0, 40 * KMH, 0.5, plan)
    assert all(after.step > before.step for before, after in pairwise(course.stretches))
    for before, after in pairwise(course.stretches):
        assert before.time_of(after.step, 1e-3) == pytest.approx(after.time, rel=1e-14)
    changes = [after for before, after in pairwise(course.stretches) if after.set_point != before.set_point]
    assert [(change.set_point) for change in changes] == [61.0, 20.0, 40.0]
    for change, point in zip(changes, plan, strict=False):
        assert point.time <= change.time < point.time + 1e-3 / 5
    # 98 s at 0.5 m/s^2 do not do: 61 m/s is not reached, and 10 s later the brake has taken off 5 m/s
    assert changes[1].speed == pytest.approx(40 * KMH + 49.0, abs=LEVEL)
    assert changes[2].speed == pytest.approx(changes[1].speed - 5.0, abs=LEVEL)
    assert course.stretches[-1].speed == 40.0


def test_a_plan_goes_on_where_it_is() -> None:
    plan = (SetPoint(0.0, 30.0), SetPoint(50.0, 25.0))
    course = standing(20.0).redirected(0, 20.0, 0.5, plan)
    assert course.at(0).set_point == 30.0
    step = 300_000
    later = course.redirected(step, course.at(step).set_point, 1.0, plan)
    assert {stretch.set_point for stretch in later.stretches} == {30.0, 25.0}
    late = course.at(10**7)
    assert later.redirected(10**7, 25.0, 1.0, plan).stretches == (
        Stretch(10**7, later.time_of(10**7), late.speed, 25.0),
    )
