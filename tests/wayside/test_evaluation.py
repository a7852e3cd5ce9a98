"""What a detector makes of a passage."""

import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wayside.detector import load_detector
from wheelset_track_sim.wayside.evaluation import channel_values, evaluated, on_bridge
from wheelset_track_sim.wayside.history import wayside_reading

TRACK = load_track("ballasted_60e1")
SINGLE = load_detector("shear_single")


def test_a_steady_load_is_read_as_it_is():
    one, two = evaluated(wayside_reading(SINGLE, TRACK, 6.0, np.full((7400, 2), [98.1e3, 80e3]), speed=20.0))
    for verdict, load in ((one, 98.1e3), (two, 80e3)):
        assert verdict.read.mean == pytest.approx(load, rel=3e-3)
        assert verdict.read.peak == pytest.approx(load, rel=0.015)
        assert (verdict.true.mean, verdict.true.peak) == (pytest.approx(load), load)
        assert verdict.read.dynamic_force == verdict.read.peak - verdict.read.mean
        assert verdict.read.dynamic_factor == pytest.approx(1.0, abs=0.015)
    assert (one.rail, two.rail) == ("rail_1", "rail_2")


def test_a_wheel_counts_when_the_low_pass_has_followed_it_onto_the_bridge():
    bridge = SINGLE.channels[0]
    on = on_bridge(bridge, 6.0, np.array([6.15, 6.175, 6.3, 6.425, 6.45]), np.full(5, 20.0), SINGLE.band)
    assert on.tolist() == [False, True, True, True, False]
    assert not on_bridge(bridge, 6.0, np.array([6.3]), np.array([200.0]), SINGLE.band).any()


def test_without_bridges_there_is_no_force_and_channels_have_their_extremes():
    detector = dataclasses.replace(load_detector("accelerometers"), band=1e3, rate=4e3)
    reading = wayside_reading(detector, TRACK, 6.0, np.full((7600, 2), 98.1e3), speed=20.0)
    one, _ = evaluated(reading)
    assert math.isnan(one.read.mean)
    assert math.isnan(one.read.dynamic_factor)
    values = {each.channel.name: each for each in channel_values(reading)}
    assert 35e3 < values["seat_1"].max < 40e3
    assert values["lift_1"].min < -0.9e-3
    assert 1e-4 < values["foot_1"].max < 4e-4  # the foot is in tension under the wheel
