"""Readings of passages: windows, speeds that change, what is refused."""

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.track.track import load_track
from wheelset_track_sim.wayside.detector import Detector, ShearBridge, load_detector
from wheelset_track_sim.wayside.history import wayside_reading, window

TRACK = load_track("ballasted_60e1")
DETECTOR = Detector("one", (ShearBridge("g", "rail_1", 0.3),), rate=5e3, band=1e3, reach=0.6)
LOAD = np.full((9000, 2), 98.1e3)


def test_samples_begin_and_end_with_the_wheelset_at_reach_from_the_gauges():
    reading = wayside_reading(DETECTOR, TRACK, 6.0, LOAD, speed=25.0)
    first, last = window(DETECTOR, TRACK, 6.0, 1e-3)
    assert (first, last) == (5550, 7050)
    assert reading.places[0] == 5.55
    assert 7.05 - 25.0 / 5e3 < reading.places[-1] <= 7.05
    assert np.allclose(np.diff(reading.times), 1 / 5e3)
    assert reading.forces.shape == (1501, 2)
    with pytest.raises(KeyError):
        reading.channel("h")


def test_forces_outside_what_counts_change_no_bit():
    short = wayside_reading(DETECTOR, TRACK, 6.0, LOAD[:7051], speed=25.0)
    longer = wayside_reading(DETECTOR, TRACK, 6.0, LOAD, speed=np.full(9000, 25.0))
    np.testing.assert_array_equal(short.values, longer.values)


def test_only_the_part_of_the_bay_counts_in_which_the_track_repeats():
    """The same passage nine bays on gives the same samples."""
    here = wayside_reading(DETECTOR, TRACK, 6.0, LOAD, speed=25.0)
    there = wayside_reading(DETECTOR, TRACK, 11.4, LOAD, speed=25.0, first_step=5400)
    np.testing.assert_allclose(there.values, here.values, atol=1e-3)


def test_a_wheel_on_one_rail_is_read_by_a_bridge_on_the_other_through_the_sleepers_alone():
    both = Detector("two", (*DETECTOR.channels, ShearBridge("h", "rail_2", 0.3)), rate=5e3, band=1e3)
    reading = wayside_reading(both, TRACK, 6.0, LOAD * [1.0, 0.0], speed=25.0)
    middle = len(reading) // 2
    assert reading.channel("g")[middle] == pytest.approx(98.1e3, rel=3e-3)
    assert abs(reading.channel("h")[middle]) < 300.0


def test_a_speed_that_changes_moves_samples_in_time_and_not_along_the_track():
    speeds = np.where(np.arange(9000) < 6000, 24.0, 25.0)
    constant, changing = (wayside_reading(DETECTOR, TRACK, 6.0, LOAD, speed=each) for each in (25.0, speeds))
    assert len(changing) > len(constant)
    np.testing.assert_allclose(np.diff(changing.places)[[10, -10]], [24.0 / 5e3, 25.0 / 5e3], rtol=1e-9)
    at = np.linspace(5.6, 7.0, 200)
    read = [np.interp(at, each.places, each.values[:, 0]) for each in (constant, changing)]
    assert np.abs(read[0] - read[1]).max() < 0.02 * 98.1e3  # where the wheel comes on, the low pass follows in time


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"position": 30.0},
            r"position = 30 m of detector one is off the line that has been run: it reads from 29",
        ),
        ({"position": 0.0}, "is off the line that has been run: it reads from -0.45 to 1.05 m, and there are forces"),
        ({"forces": LOAD[:, :1]}, "forces are no finite numbers of shape"),
        ({"forces": LOAD * np.nan}, "forces are no finite numbers of shape"),
        ({"speed": 0.0}, "speed is not above 0 m/s at every step"),
        ({"speed": 1.9}, "band = 1000 Hz of detector one is above half the 1900 steps a second"),
        ({"step_length": 7e-4}, "step_length = 0.0007 m does not divide the spacing of 0.6 m"),
    ],
)
def test_what_cannot_be_read_is_refused(keys, message):
    with pytest.raises(InputError, match=message):
        wayside_reading(
            **{"detector": DETECTOR, "track": TRACK, "position": 6.0, "forces": LOAD, "speed": 25.0, **keys}
        )


def test_the_array_reads_a_hit_in_the_middle_of_a_bay_only_there():
    forces = LOAD.copy()
    forces[:, 0] += 150e3 * np.exp(-(((np.arange(9000) - 7500) / 30.0) ** 2))  # 2 ms at 25 m/s
    reading = wayside_reading(load_detector("shear_array"), TRACK, 3.6, forces, speed=25.0)
    hit = [reading.channel(f"bay_{bay}_rail_1")[np.abs(reading.places - 7.5) < 0.05].max() for bay in range(1, 9)]
    assert np.argmax(hit) == 6
    assert hit[6] > 200e3
    assert max(hit[:6] + hit[7:]) < 50e3
