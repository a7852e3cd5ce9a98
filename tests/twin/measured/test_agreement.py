"""Error measures against what they are by definition."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.twin.measured.agreement import agreement, paired, peaks

TIME = np.arange(4000) / 4000
WAVE = np.sin(2 * np.pi * 10 * TIME)


def test_two_signals_that_are_the_same_have_no_error() -> None:
    found = agreement(5 + WAVE, 5 + WAVE)
    assert found.rms_error == found.peak_error == found.mean_error == found.magnitude_error == 0
    assert found.phase_error == pytest.approx(0, abs=1e-7)
    assert found.correlation == found.gain == pytest.approx(1)


@given(st.floats(0.2, 5.0))
def test_a_factor_is_an_error_of_magnitude_alone(factor: float) -> None:
    found = agreement(WAVE, factor * WAVE)
    assert found.magnitude_error == pytest.approx(factor - 1, abs=1e-12)
    assert found.phase_error == pytest.approx(0, abs=1e-7)
    assert found.gain == pytest.approx(1 / factor)
    relative = factor - 1 / factor  # (s^2 - 1) / s of Russell
    assert found.russell_magnitude_error == pytest.approx(math.copysign(math.log10(1 + abs(relative)), relative))


@given(st.floats(0.0, 0.5))
def test_a_delay_is_an_error_of_phase_alone(share: float) -> None:
    found = agreement(WAVE, np.sin(2 * np.pi * (10 * TIME - share)))
    assert found.phase_error == pytest.approx(2 * share, abs=1e-6)  # of half a wave, which is opposite phase
    assert found.magnitude_error == pytest.approx(0, abs=1e-9)
    assert found.russell_comprehensive_error == pytest.approx(math.sqrt(math.pi / 4) * 2 * share, abs=1e-6)


@given(st.floats(-3.0, 3.0))
def test_an_offset_is_told_by_the_means(offset: float) -> None:
    found = agreement(WAVE + 4.0, WAVE + 4.0 + offset)
    assert found.mean_error == pytest.approx(offset, abs=1e-12)
    assert found.rms_error == pytest.approx(abs(offset), abs=1e-12)
    assert found.relative_error == pytest.approx(abs(offset) / math.sqrt(16.5), abs=1e-9)
    assert found.comprehensive_error == pytest.approx(0, abs=1e-7)


def test_a_signal_that_does_not_change_leaves_ratios_undefined() -> None:
    found = agreement(np.ones(20), WAVE[:20])
    assert math.isnan(found.magnitude_error)
    assert math.isnan(found.gain)
    assert found.rms_error > 0


def test_impacts_are_paired_one_by_one() -> None:
    at = np.arange(1000) * 1e-3
    measured, simulated = np.zeros(1000), np.zeros(1000)
    measured[[100, 104, 500]] = 3.0, 5.0, 4.0
    simulated[[110, 800]] = 6.0, 2.5
    assert peaks(at, measured, 2.0, 0.05) == [104, 500]
    found = paired("wheel_1", at, measured, simulated, 2.0, 0.05)
    assert (found[0].at, found[0].measured, found[0].simulated) == (pytest.approx(0.104), 5.0, 6.0)
    assert found[0].error == pytest.approx(0.2)
    assert math.isnan(found[1].simulated)
    assert math.isnan(found[2].measured)
    assert len(found) == 3
