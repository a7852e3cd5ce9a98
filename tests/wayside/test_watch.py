"""Detectors along a run: each passage has the same bits however the run is cut."""

import numpy as np
import pytest

from support.blocks import block_of_numbers
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wayside.detector import Detector, ShearBridge, WaysideDetector
from wheelset_track_sim.wayside.watch import WaysideWatch, passages

TRACK = load_track("ballasted_60e1")
ONE = Detector("one", (ShearBridge("g", "rail_1", 0.3), ShearBridge("h", "rail_2", 0.3)), rate=5e3, band=1e3)
STANDING = (WaysideDetector(ONE, 12.0, "later"), WaysideDetector(ONE, 1.2))


def blocks(*lengths, first=0, speed=25.0):
    time = first * 1e-3 / speed
    for length in lengths:
        yield block_of_numbers(first, length, time=time, speed=speed, revision=first // 5000)
        first, time = first + length, time + length * 1e-3 / speed


def test_passages_come_in_the_order_of_the_track_and_once_each():
    watch = WaysideWatch(STANDING, TRACK, 1e-3)
    found = [[passage.topic for passage in watch.push(block)] for block in blocks(2000, 251, 5000, 5799, 1, 500)]
    assert found == [[], ["wayside/one"], [], [], ["wayside/later"], []]


@pytest.mark.parametrize("lengths", [(13500,), (1389,) * 10, (7, 6000, 333, 8000)])
def test_bits_do_not_depend_on_how_the_run_is_cut(lengths):
    whole = list(passages(STANDING, TRACK, 1e-3, blocks(14000)))
    for one, other in zip(whole, passages(STANDING, TRACK, 1e-3, blocks(*lengths)), strict=True):
        np.testing.assert_array_equal(one.reading.values, other.reading.values)
        assert (one.time, one.first_step, one.speed, one.position) == (
            other.time,
            other.first_step,
            other.speed,
            other.position,
        )


def test_a_passage_says_when_and_where_it_begins():
    [first, later] = passages(STANDING, TRACK, 1e-3, blocks(8000, 6000))
    assert (first.first_step, first.position, first.speed, first.revision) == (750, 0.75, 25.0, 0)
    assert (later.first_step, later.revision) == (11550, 1)
    assert later.time == pytest.approx(11.55 / 25.0, rel=1e-12)
    assert later.step_period == 1 / 5e3
    assert [verdict.rail for verdict in later.verdicts] == ["rail_1", "rail_2"]


def test_a_detector_that_was_passed_before_the_recording_or_in_a_gap_gives_nothing():
    assert [passage.topic for passage in passages(STANDING, TRACK, 1e-3, blocks(12000, first=2000))] == [
        "wayside/later"
    ]
    watch = WaysideWatch(STANDING, TRACK, 1e-3)
    parts = [*blocks(3000), *blocks(2000, first=12000)]
    assert [passage.topic for block in parts for passage in watch.push(block)] == ["wayside/one"]


def test_only_steps_that_count_are_kept():
    watch = WaysideWatch(STANDING, TRACK, 1e-3)
    for block in blocks(*(500,) * 20):
        watch.push(block)
    assert watch._steps.first == 11400 - 14 * 600
    for block in blocks(*(500,) * 20, first=10000):
        watch.push(block)
    assert len(watch._steps.forces) == 0
