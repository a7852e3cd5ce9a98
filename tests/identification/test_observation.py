"""What is measured: refusals in one line, and the part of a record that is used."""

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.identification.observation import Observation, PeakReading

TIME = np.arange(4000) / 10e3
QUIET = 1e5 + np.zeros(4000)


def peaked(*rows):
    values = QUIET.copy()
    values[list(rows)] = 2.5e5
    return values


def test_a_force_is_used_around_its_peak():
    first, peak, end = Observation("force", TIME, peaked(2000), speed=25.0).window(2.7)
    assert (first, peak, end) == (2000 - 200, 2000, 2000 + 480)


def test_turns_are_used_of_a_signal_of_the_wheelset_with_track_before_the_first_hit():
    turn = round(2.7 / 25.0 * 10e3)
    hits = [700, 700 + turn, 700 + 2 * turn]
    for highest in hits:
        values = peaked(*hits)
        values[highest] = 3e5
        first, peak, end = Observation("box", TIME, values, speed=25.0).window(2.7)
        assert peak == highest
        assert first == pytest.approx(700 - 80, abs=2)
        assert end == pytest.approx(700 + 3 * turn - 80, abs=2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": TIME[:20], "values": QUIET[:20]}, "has 20 times and 20 values: give 32 of each or more"),
        ({"values": QUIET * np.nan}, "has values that are not finite"),
        ({"time": TIME**2}, "is not sampled at even times"),
        ({"speed": 1.0}, "speed = 1 m/s is out of range"),
        ({"gain_error": 0.9}, "gain_error = 0.9 is out of range"),
    ],
)
def test_what_cannot_be_used_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        Observation(**({"signal": "force", "time": TIME, "values": QUIET} | change))


def test_a_peak_below_the_static_load_is_refused():
    with pytest.raises(InputError, match="force = 90000 N is not above the static wheel load of 98100 N"):
        PeakReading(90e3)


def test_a_peak_is_uncertain_by_noise_and_gain():
    assert PeakReading(200e3, noise=3e3, gain_error=0.02).spread == pytest.approx(5e3)
