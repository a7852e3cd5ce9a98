import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.live.pacing import Pace, Pacer, SteadyClock


class Clock:
    """A clock that goes when it is told to; sleeping makes it due."""

    def __init__(self):
        self.time, self.epoch = 17.0, 0

    def now(self):
        return self.time

    def sleep(self, due, wake):
        self.time = due


def test_sample_is_due_when_its_time_at_the_factor_has_passed():
    clock = Clock()
    pacer = Pacer(4.0, simulated=10.0, clock=clock)
    assert pacer.wait(12.0) == pytest.approx(0.5)
    clock.time += 0.75
    assert pacer.wait(12.0) == pytest.approx(-0.25)
    assert pacer.wait(13.0) == pytest.approx(0.0)


def test_sleep_ends_when_the_sample_is_due():
    clock = Clock()
    pacer = Pacer(4.0, simulated=10.0, clock=clock)
    pacer.sleep(12.0, threading.Event())
    assert clock.time == pytest.approx(17.5)
    assert pacer.wait(12.0) == pytest.approx(0.0)


def test_clock_that_stands_makes_nothing_due():
    clock = Clock()
    pacer = Pacer(1.0, 0.0, clock)
    assert pacer.wait(0.05) == pacer.wait(0.05) == pytest.approx(0.05)


@pytest.mark.parametrize("jump", [-1e6, 1.7e9])
def test_clock_that_is_set_anew_begins_a_schedule_behind_the_last_sample_that_was_due(jump):
    clock = Clock()
    pacer = Pacer(2.0, 0.0, clock)
    clock.time += 1.0
    assert pacer.wait(2.0) == pytest.approx(0.0)
    clock.time += jump
    clock.epoch += 1
    assert pacer.wait(2.1) == pytest.approx(0.05)
    clock.time += 0.05
    assert pacer.wait(2.1) == pytest.approx(0.0, abs=1e-6)


def test_clock_that_leaps_without_being_set_anew_makes_the_run_overdue():
    clock = Clock()
    pacer = Pacer(1.0, 0.0, clock)
    clock.time += 100
    assert pacer.wait(0.05) == pytest.approx(-99.95)


def test_factor_zero_never_waits():
    clock = Clock()
    pacer = Pacer(0.0, 0.0, clock)
    clock.time += 100
    assert pacer.wait(1e6) == 0.0


def test_steady_clock_sleeps_until_it_is_due_or_woken():
    clock, wake = SteadyClock(), threading.Event()
    due = clock.now() + 0.01
    clock.sleep(due, wake)
    assert clock.now() >= due
    wake.set()
    clock.sleep(clock.now() + 1e6, wake)


@given(
    chunk=st.floats(0.001, 1.0),
    period=st.floats(2e-6, 4e-4),
    duration=st.floats(0.001, 20.0),
)
def test_chunks_add_up_to_the_duration(chunk, period, duration):
    pace = Pace(chunk_duration=chunk, duration=duration)
    whole = round(duration / period)
    done = 0
    for _ in range(whole + 1):
        steps = pace.steps(done * period, period)
        if steps == 0:
            break
        assert steps <= max(1, round(chunk / period))
        done += steps
        if done < whole // 2:  # the first half need not be walked
            done = whole // 2
    assert done == whole


def test_endless_run_has_whole_chunks_for_ever():
    assert Pace().steps(1e9, 36e-6) == round(0.05 / 36e-6)


@pytest.mark.parametrize("field", ["chunk_duration", "real_time_factor", "duration"])
def test_refusals_name_the_field(field):
    with pytest.raises(InputError, match=f"^{field} = -1 .*is out of range"):
        Pace(**{field: -1.0})
