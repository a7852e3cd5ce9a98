"""Amplitudes that points of a turning axle go through, against closed forms and every point by itself."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.samples.rotating_bending import RotatingBending

TURN = 2713
ANGLES = 2 * np.pi * np.arange(TURN) / TURN


def worst(bending: np.ndarray) -> float:
    """Half the range that each of 720 points sees over a turn, of the worst."""
    seen = (np.ptp(bending * np.cos(ANGLES + phi)) / 2 for phi in np.linspace(0, np.pi, 720, endpoint=False))
    return float(max(seen))


def test_of_a_constant_bending_stress_it_is_that_stress():
    [found] = RotatingBending(TURN, 1).push(0, np.full((TURN, 1), 65.3e6))
    assert found[0] == pytest.approx(65.3e6, rel=1e-3)


def test_one_peak_in_a_turn_counts_half():
    """The point that passes the top with the peak sees it once, and half a turn later the static stress."""
    bending = np.full((TURN, 1), 60e6)
    bending[500] = 100e6
    [found] = RotatingBending(TURN, 1).push(0, bending)
    assert found[0] == pytest.approx(80e6, rel=1e-3)


def test_a_load_that_turns_with_the_axle_is_no_amplitude():
    """A stress in the turning axle goes as 1 / cos in axes at rest: here as far as that is finite."""
    bending = 10e6 * np.cos(ANGLES)[:, np.newaxis]  # 10 cos^2 of the point at 0: from 0 to 10
    [found] = RotatingBending(TURN, 1).push(0, bending)
    assert found[0] == pytest.approx(worst(bending[:, 0]), rel=1.1e-3)
    assert found[0] == pytest.approx(5e6, rel=1.1e-3)


@given(seed=st.integers(0, 2**32 - 1), peaks=st.integers(0, 6))
def test_it_is_that_of_the_worst_of_all_points(seed, peaks):
    random = np.random.default_rng(seed)
    at, size, width = random.uniform(0, TURN, peaks), random.uniform(0, 60e6, peaks), random.uniform(20, 200, peaks)
    bending = 60e6 + 5e6 * np.sin(random.integers(1, 9) * ANGLES)
    for place, height, length in zip(at, size, width, strict=True):
        bending += height * np.exp(-(((np.arange(TURN) - place) / length) ** 2))
    [found] = RotatingBending(TURN, 1).push(0, bending[:, np.newaxis])
    assert found[0] == pytest.approx(worst(bending), rel=1.1e-3)


@given(cuts=st.lists(st.integers(1, 2000), max_size=8), first=st.integers(0, 3 * TURN), turn=st.integers(5, 900))
def test_it_does_not_depend_on_blocks(cuts, first, turn):
    bending = np.random.default_rng(1).normal(60e6, 20e6, (sum(cuts), 2))
    whole, parts = RotatingBending(turn, 2), RotatingBending(turn, 2)
    expected = whole.push(first, bending) if cuts else []
    found, row = [], 0
    for count in cuts:
        found += parts.push(first + row, bending[row : row + count])
        row += count
    assert found == expected
    assert str(parts.amplitudes) == str(whole.amplitudes)


def test_before_a_turn_is_complete_its_amplitude_so_far_is_there():
    watch = RotatingBending(TURN, 1)
    assert watch.push(1000, np.full((TURN, 1), 50e6)) == []  # begins within a turn
    begun, turn = watch.amplitudes
    assert math.isnan(turn[0])
    assert 0 < begun[0] <= 50e6
    assert RotatingBending(TURN, 0).amplitudes == ((), ())
