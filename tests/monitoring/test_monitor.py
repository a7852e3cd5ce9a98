"""Levels while a run streams: raised at once, lowered after a report period and a turn without a peak."""

import math

import numpy as np
import pytest

from wheelset_track_sim.live.run_messages import Events
from wheelset_track_sim.live.stream import Timing
from wheelset_track_sim.monitoring.limits import Limits
from wheelset_track_sim.monitoring.monitor import Monitor
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.samples.impacts import Impact
from wheelset_track_sim.samples.summary import summarise
from wheelset_track_sim.samples.turns import NO_TURN, TurnPeaks
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.verdict.limit_set import Level, load_limits

STATIC = 100e3
TURN = 100
"""Steps: each block is a turn."""
MEANS = np.zeros((2, 6))
ON_TIME = Timing(1.0, 0.0)
ON = load_scenario("damage_wheel_1", [f"axle_load={2 * STATIC}"])


class Clock:
    now = 50.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def monitor(clock):
    return Monitor(("A1", "B1"), 200e3, Limits(), TURN, MEANS, clock)


def push(monitor, force=STATIC, stress=60e6, timing=ON_TIME, turn=NO_TURN, impacts=()):
    """One turn of 0.1 s in which wheel 2 rests, A1 bends all along, and B1 half as much."""
    forces = np.full((100, 2), STATIC)
    forces[50, 0] = force
    stresses = np.zeros((100, 2, 6))
    stresses[:, :, 1] = stress, stress / 2
    block = SampleBlock(0, 0.0, 1e-3, 1.0, 0.0, 0, forces, stresses, ("A1", "B1"))
    return monitor.push(block, summarise(block), Events(list(impacts), turn), timing, ON)


def levels(statuses):
    return {status.name: status.level for status in statuses}


def values(statuses, name):
    return dict(next(status.values for status in statuses if status.name == name))


def turn_of(force, stress=60e6):
    return TurnPeaks(3, (force, STATIC), (stress, stress / 2))


def test_before_the_first_sample_nothing_is_known(monitor):
    found = monitor.report()
    assert [status.name for status in found] == ["wheel_1", "wheel_2", "stress A1", "stress B1", "pacing"]
    assert {status.level for status in found} == {Level.STALE}
    assert found[0].message == "no sample yet"


@pytest.mark.parametrize(
    ("force", "level"),
    [(200e3, Level.OK), (200.1e3, Level.WARN), (350e3, Level.WARN), (350.1e3, Level.ERROR)],
)
def test_level_of_a_wheel(monitor, force, level):
    push(monitor, force)
    found = monitor.report()
    assert levels(found)["wheel_1"] == level
    assert levels(found)["wheel_2"] == Level.OK
    assert float(values(found, "wheel_1")["peak_force_N"]) == force
    assert float(values(found, "wheel_1")["dynamic_factor"]) == pytest.approx(force / STATIC, rel=1e-5)


@pytest.mark.parametrize(
    ("stress", "level"),
    [(166e6, Level.OK), (167e6, Level.WARN), (200e6, Level.WARN), (201e6, Level.ERROR)],
)
def test_level_of_a_node_is_that_of_the_amplitude(monitor, stress, level):
    """Of a stress that is constant where nothing turns, a point of the turning axle sees plus and minus that."""
    push(monitor, stress=stress)
    found = monitor.report()
    assert levels(found)["stress A1"] == level
    assert levels(found)["stress B1"] == Level.OK
    for name in ("bending_amplitude_Pa", "turn_bending_amplitude_Pa", "max_principal_Pa"):
        assert float(values(found, "stress A1")[name]) == pytest.approx(stress, rel=1e-5)


def test_a_press_fit_is_a_mean_and_no_amplitude(clock):
    means = np.zeros((2, 6))
    means[0, 1] = 150e6
    monitor = Monitor(("A1", "B1"), 200e3, Limits(), TURN, means, clock)
    push(monitor, stress=210e6)  # 60 MPa of it from bending
    found = monitor.report()
    assert levels(found)["stress A1"] == Level.OK
    assert float(values(found, "stress A1")["bending_amplitude_Pa"]) == pytest.approx(60e6, rel=1e-5)
    assert float(values(found, "stress A1")["mean_axial_Pa"]) == 150e6
    assert next(each.message for each in found if each.name == "stress A1") == (
        "bending amplitude 60.0 MPa about a mean of 150.0 MPa"
    )


@pytest.mark.parametrize(
    ("factor", "lag", "level"),
    [
        (1.0, 0.2, Level.OK),
        (1.0, 0.21, Level.WARN),
        (1.0, 2.1, Level.ERROR),
        (0.91, 0.0, Level.OK),
        (0.89, 0.0, Level.WARN),
        (0.49, 0.0, Level.ERROR),
        (3.0, 0.0, Level.OK),
    ],
)
def test_level_of_the_pace(monitor, factor, lag, level):
    monitor.wanted = 1.0
    for _ in range(10):
        push(monitor, timing=Timing(factor, lag))
    assert levels(monitor.report())["pacing"] == level


def test_the_real_time_factor_is_that_of_the_whole_period(monitor):
    monitor.wanted = 1.0
    push(monitor, timing=Timing(0.1, 0.0))
    for _ in range(9):
        push(monitor, timing=Timing(10.0, 0.0))
    found = float(values(monitor.report(), "pacing")["real_time_factor"])
    assert found == pytest.approx(1.0 / (0.1 / 0.1 + 9 * 0.1 / 10), rel=1e-5)


def test_one_late_chunk_before_a_report_that_comes_early_is_no_alarm(monitor):
    monitor.wanted = 1.0
    for force in (STATIC, 250e3):  # each worse than what was told
        assert push(monitor, force, timing=Timing(0.45, 0.1))
        found = monitor.report()
        assert levels(found)["pacing"] == Level.OK
        assert values(found, "pacing")["real_time_factor"] == "nan"
    for _ in range(9):
        push(monitor)
    whole = values(monitor.report(), "pacing")["real_time_factor"]
    assert float(whole) == pytest.approx(1.1 / (0.2 / 0.45 + 0.9), rel=1e-5)  # of all since the start
    push(monitor, 360e3, timing=Timing(0.4, 0.0))
    found = monitor.report()  # early again: what was measured last holds
    assert levels(found)["pacing"] == Level.WARN
    assert values(found, "pacing")["real_time_factor"] == whole


def test_what_was_reached_is_no_answer_to_another_wish(monitor):
    monitor.wanted = 0.5
    for _ in range(10):
        push(monitor, timing=Timing(0.5, 0.0))
    assert levels(monitor.report())["pacing"] == Level.OK
    monitor.wanted = 5.0
    push(monitor, 250e3, timing=Timing(5.0, 0.0))
    assert levels(monitor.report())["pacing"] == Level.OK


def test_as_fast_as_possible_is_never_too_slow(monitor):
    push(monitor, timing=Timing(0.01, 0.0))
    assert levels(monitor.report())["pacing"] == Level.OK


def test_what_gets_worse_is_told_at_once_and_only_once(monitor):
    assert push(monitor)  # the first sample
    monitor.report()
    assert not push(monitor)
    assert push(monitor, 250e3)
    monitor.report()
    assert not push(monitor, 260e3)
    assert push(monitor, 360e3)
    monitor.report()
    assert not push(monitor, 250e3)  # better is told with the period
    assert push(monitor, timing=Timing(1.0, 5.0))


def test_a_peak_stays_for_a_period_and_for_a_turn(monitor):
    push(monitor, 300e3)
    assert levels(monitor.report())["wheel_1"] == Level.WARN
    push(monitor, turn=turn_of(300e3))  # the turn with the peak is the last complete one
    found = monitor.report()
    assert levels(found)["wheel_1"] == Level.WARN
    assert float(values(found, "wheel_1")["turn_peak_force_N"]) == 300e3
    push(monitor, turn=turn_of(STATIC))
    assert levels(monitor.report())["wheel_1"] == Level.OK


def test_impacts_are_counted_from_the_start_and_contact_loss_by_periods(monitor):
    impact = Impact(0, 1, 0.0, 1.0, 0.0, 0, 0.0, 3e5, STATIC, 0.0, 0.0, 2e5)
    push(monitor, 300e3, impacts=[impact])
    push(monitor, 0.0, impacts=[impact])
    first = values(monitor.report(), "wheel_1")
    push(monitor)
    second = values(monitor.report(), "wheel_1")
    assert (first["impacts"], second["impacts"]) == ("2", "2")
    assert float(first["contact_loss_s"]) == pytest.approx(1e-3, rel=1e-5)
    assert float(second["contact_loss_s"]) == 0.0


def test_silence_is_stale_and_ends_with_the_next_sample(monitor, clock):
    push(monitor, 300e3)
    monitor.report()
    clock.now += 9.0
    assert levels(monitor.report())["wheel_1"] == Level.WARN  # a chunk that takes long
    clock.now += 2.0
    found = monitor.report()
    assert {status.level for status in found} == {Level.STALE}
    assert found[0].message == "no sample for 11 s"
    assert float(values(found, "wheel_1")["peak_force_N"]) == 300e3  # the last that is known
    push(monitor)
    assert levels(monitor.report())["wheel_1"] == Level.OK


def test_a_pause_is_stale_with_its_reason(monitor):
    push(monitor)
    found = monitor.stale("paused")
    assert {(status.level, status.message) for status in found} == {(Level.STALE, "paused")}


def test_limits_and_threshold_may_change(monitor):
    push(monitor, 250e3)
    monitor.report()
    monitor.limits, monitor.threshold = Limits(force_error=240e3), 230e3
    assert push(monitor, 250e3)
    assert levels(monitor.report())["wheel_1"] == Level.ERROR


def test_before_the_first_turn_its_peak_is_nan(monitor):
    push(monitor)
    assert math.isnan(float(values(monitor.report(), "wheel_1")["turn_peak_force_N"]))


def test_a_set_of_limits_adds_a_verdict_that_names_each_comparison(clock):
    monitor = Monitor(("A1", "B1"), 200e3, Limits(), TURN, MEANS, clock, load_limits("trafikverket"))
    assert [status.name for status in monitor.report()][-1] == "verdict"
    push(monitor, force=300e3)
    (*_, found) = monitor.report()
    assert (found.name, found.level) == ("verdict", Level.OK)
    assert values([found], "verdict")["wheel_1.damage_length"].startswith("ok: wheel 1: length of tread damage 60 mm")
    assert push(monitor, force=360e3)  # reported at once
    (*_, found) = monitor.report()
    assert found.level == Level.ERROR
    assert found.message.endswith("is above 350 kN: stop the train for a visual inspection (trafikverket)")
