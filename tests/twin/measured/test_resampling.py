"""Signals on another axis."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.resampling import band_limited, shifted
from wheelset_track_sim.twin.measured.measurement import Measurement, evenly

STEPS = np.arange(600.0)


def wave(at: np.ndarray, frequency: float, phase: float = 0.3) -> np.ndarray:
    """Of a frequency in waves a step."""
    return np.cos(2 * np.pi * frequency * at + phase)[:, np.newaxis]


@settings(max_examples=30)
@given(st.floats(0.0, 0.39), st.floats(0.3, 3.0), st.floats(0.0, 1.0))
def test_waves_of_the_band_pass(frequency: float, spacing: float, offset: float) -> None:
    """Up to 80 % of half the lower sampling rate, wherever the new samples stand."""
    width = max(1.0, spacing)
    places = np.arange(200.0, 400.0, spacing) + offset
    found = band_limited(wave(STEPS, frequency / width), places, width)
    np.testing.assert_allclose(found, wave(places, frequency / width), atol=2e-4)


@settings(max_examples=30)
@given(st.floats(0.52, 0.9), st.floats(1.9, 4.0))
def test_waves_above_the_new_band_are_gone(frequency: float, width: float) -> None:
    """They would come back as waves that are not there."""
    places = np.arange(200.0, 400.0, width)
    assert np.abs(band_limited(wave(STEPS, frequency / width), places, width)).max() < 2e-4


@given(st.floats(-1e6, 1e6), st.floats(-5.0, 620.0))
def test_a_constant_stays_also_beyond_the_ends(value: float, place: float) -> None:
    assert band_limited(np.full((600, 1), value), np.array([place]))[0, 0] == pytest.approx(value)


@settings(max_examples=30)
@given(st.floats(-100.0, 100.0), st.integers(0, 100))
def test_a_shift_is_the_same_by_convolution(steps: float, behind: int) -> None:
    signals = np.random.default_rng(3).standard_normal((120, 2))
    start, end = math.ceil(steps) + behind, math.floor(steps + 119) + 1
    found = shifted(signals, start, end, steps)
    np.testing.assert_allclose(found, band_limited(signals, np.arange(start, end) - steps), atol=1e-6)


def test_uneven_samples_are_evened() -> None:
    chance = np.random.default_rng(1)
    at = np.arange(400) * 1e-3 + chance.uniform(-2e-4, 2e-4, 400)
    measured = Measurement(Path("a"), "time", at, {"wheel_1": wave(at * 1e3, 0.05)[:, 0]})
    assert not measured.even
    found = evenly(measured)
    even = found.start + found.step * np.arange(400)
    np.testing.assert_allclose(found.signals[20:-20], wave(even * 1e3, 0.05)[20:-20], atol=1e-3)


@pytest.mark.parametrize(
    ("rate", "digits", "start"), [(8e3, 4, 0.1234), (3e3, 4, 1.7e9), (12e3, 5, -3.0), (400.0, 3, 1e4)]
)
def test_rounded_stamps_of_even_samples_move_none(rate: float, digits: int, start: float) -> None:
    """A spline through stamps that are off by a third of a step would make noise of a third of the signal."""
    at = np.round(start + np.arange(4000) / rate, digits)
    samples = wave(np.arange(4000.0), 0.3)
    assert not Measurement(Path("a"), "time", at, {"wheel_1": samples[:, 0]}).even
    found = evenly(Measurement(Path("a"), "time", at, {"wheel_1": samples[:, 0]}))
    np.testing.assert_array_equal(found.signals, samples)
    assert found.step == pytest.approx(1 / rate, rel=1e-5)
    assert found.start == pytest.approx(start, abs=0.02 / rate + 1e-6)


@pytest.mark.parametrize(
    ("at", "force", "reason"),
    [
        (STEPS, np.where(STEPS == 7, np.nan, 1.0), r"wheel_1 of sample 7 is nan: give finite numbers"),
        (np.where(STEPS == 9, np.inf, STEPS), STEPS, "time of sample 9 is inf"),
        (np.where(STEPS == 5, 3.0, STEPS), STEPS, "time of sample 5 is not greater than the one before it"),
    ],
)
def test_records_of_other_programs_are_checked_too(at: np.ndarray, force: np.ndarray, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        Measurement(Path("a"), "time", at, {"wheel_1": force})


def test_gaps_are_refused() -> None:
    at = np.delete(np.arange(400) * 1e-3, slice(100, 110))
    with pytest.raises(InputError, match=r"gap of 0.011 after 0.099, 11.0 steps wide"):
        evenly(Measurement(Path("a"), "time", at, {"wheel_1": at}))
