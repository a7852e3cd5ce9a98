"""Streamed rainflow against ASTM E1049 as it is printed, on random and on hostile series."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow, StressSpectrum
from wheelset_track_sim.fatigue.rainflow_kernels import CAPACITY, DEPTH

CURVE = load_curve("assumed_body")
MPA = 1e6
SERIES = st.lists(st.one_of(st.integers(-60, 60), st.floats(-60, 60)), min_size=1, max_size=80)
GATES = st.sampled_from([0.0, 0.05, 1.0, 4.5])


def reversals(series):
    """Ends and reversals of a series."""
    steps = [x for x, before in zip(series, [None, *series], strict=False) if x != before]
    inner = [b for a, b, c in zip(steps, steps[1:], steps[2:], strict=False) if (b - a) * (c - b) < 0]
    return [steps[0], *inner, *steps[-1:]] if len(steps) > 1 else steps


def three_point(series):
    """Ranges with half cycles by the rules of ASTM E1049-85, 5.4.4, in their order."""
    found, points = [], []
    for point in reversals(series):
        points.append(point)
        while len(points) >= 3:
            x, y = abs(points[-1] - points[-2]), abs(points[-2] - points[-3])
            if x < y:
                break
            if len(points) == 3:  # Y contains the starting point
                found.append((y, 1))
                points.pop(0)
            else:
                found.append((y, 2))
                del points[-3:-1]
    return found + [(abs(b - a), 1) for a, b in pairwise(points)]


def damage(ranges):
    shares = [(size / 2 * MPA / CURVE.limit, halves / 2) for size, halves in ranges]
    return sum(cycles * share**CURVE.slope / CURVE.knee_cycles for share, cycles in shares)


def counted(*series, gate=0.0):
    count = Rainflow(len(series), CURVE, gate * MPA)
    count.push(np.array(series, dtype=float) * MPA)
    return count.spectrum


def equal(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in StressSpectrum.__dataclass_fields__)


def test_the_example_of_the_standard():
    """Fig. 6 of ASTM E1049-85: ranges 3, 4, 6, 8, 9 with 0.5, 1.5, 0.5, 1.0, 0.5 cycles; a unit is 25 MPa here."""
    spectrum = counted([25 * each for each in (-2, 1, -3, 5, -1, 3, -4, 4, -2)])
    cycles = dict(zip(spectrum.ranges / (25 * MPA), spectrum.half_cycles[0].sum(axis=1) / 2, strict=True))
    assert {size: number for size, number in cycles.items() if number} == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    assert spectrum.cycles[0] == 4.0
    assert spectrum.damage[0, 0] == pytest.approx(damage([(75, 1), (100, 3), (150, 1), (200, 2), (225, 1)]), rel=1e-12)


@given(series=SERIES, gate=GATES)
def test_it_equals_the_standard_on_random_series(series, gate):
    spectrum = counted(series, gate=gate)
    kept = [(size, halves) for size, halves in three_point(series) if size * MPA > gate * MPA]
    expected = np.zeros(len(spectrum.ranges), dtype=int)
    for size, halves in kept:
        expected[int(size * MPA / (spectrum.ranges[1]))] += halves
    # A range that is at a border but for rounding may be on either side of it.
    borders = any(abs(size / 5 - round(size / 5)) < 1e-6 and size != int(size) for size, _ in kept)
    if not borders:
        assert spectrum.half_cycles[0].sum(axis=1).tolist() == expected.tolist()
    assert spectrum.damage[0, 0] == pytest.approx(damage(kept), rel=1e-9, abs=1e-300)
    assert not spectrum.forced.any()


@given(series=SERIES, gate=GATES)
def test_what_is_merged_is_bounded(series, gate):
    merged = sum(halves / 2 for size, halves in three_point(series) if size <= gate)
    spectrum = counted(series, gate=gate)
    assert abs(spectrum.merged[0] - merged) <= 1
    whole = counted(series).damage[0]
    limit = damage([(gate, 2)]) * (spectrum.merged[0] + 1)
    assert -1e-9 * whole[0] <= whole[0] - spectrum.damage[0, 0] <= limit + 1e-9 * whole[0]


@given(series=SERIES, cuts=st.lists(st.integers(0, 80), max_size=6), gate=GATES)
def test_chunks_and_a_resumed_count_give_the_same_bits(series, cuts, gate):
    stress = np.array([series, series[::-1]], dtype=float) * MPA
    whole, parts = Rainflow(2, CURVE, gate * MPA), Rainflow(2, CURVE, gate * MPA)
    whole.push(stress)
    for start, end in pairwise([0, *sorted(min(cut, len(series)) for cut in cuts), len(series)]):
        resumed = Rainflow(2, CURVE, gate * MPA)
        resumed.resume(parts.saved())
        parts = resumed
        parts.push(stress[:, start:end])
        assert parts.spectrum.cycles.min() >= 0  # to look at it does not change it
        assert parts.damage.tobytes() == parts.spectrum.damage.tobytes()
    assert equal(parts.spectrum, whole.spectrum)


def test_levels_are_crossed_as_often_as_the_signal_does():
    series = np.random.default_rng(3).normal(0.0, 40.0, 500)
    spectrum = counted(series.tolist())
    levels = spectrum.levels / MPA
    expected = [int(np.sum((series[:-1] < level) & (series[1:] >= level))) for level in levels]
    assert spectrum.crossings[0].tolist() == expected


def test_means_are_those_of_the_cycles():
    spectrum = counted([0, 100, 20, 60, 0])
    cells = np.argwhere(spectrum.half_cycles[0] == 2)
    found = {(spectrum.ranges[row] / MPA, spectrum.means[column] / MPA) for row, column in cells}
    assert found == {(100, 50), (40, 40)}
    assert spectrum.cycles[0] == 2.0


def test_spectra_add_up():
    one, two = counted([0, 100, -50, 30, 0]), counted([0, 20, -70, 60, -60, 0])
    both = one + two
    assert both.cycles[0] == one.cycles[0] + two.cycles[0]
    assert both.damage[0, 0] == one.damage[0, 0] + two.damage[0, 0]
    assert np.array_equal(both.half_cycles, one.half_cycles + two.half_cycles)


@pytest.mark.parametrize(
    "sizes",
    [
        np.linspace(0.0, 300.0, 20_000),
        np.linspace(300.0, 0.0, 20_000),
        np.concatenate([np.linspace(300.0, 1.0, 5000), np.linspace(1.0, 310.0, 5000)]),
        100.0 + 1e-7 * np.arange(20_000),
    ],
    ids=["growing", "shrinking", "both", "hardly_growing"],
)
def test_memory_is_bounded_and_no_range_is_lost(sizes):
    series = (sizes * (-1.0) ** np.arange(len(sizes))).tolist()
    count = Rainflow(1, CURVE, 0.0)
    count.push(np.array([series]) * MPA)
    assert count.state.counts[0, DEPTH] <= CAPACITY
    spectrum = count.spectrum
    assert spectrum.forced[0] > 1000
    assert count.damage.tobytes() == spectrum.damage.tobytes()
    exact = three_point(series)
    assert spectrum.cycles[0] == sum(halves for _, halves in exact) / 2
    assert spectrum.damage[0, 0] == pytest.approx(damage(exact), rel=2e-2)


@pytest.mark.parametrize("growth", [0.0, 1e-9, -1e-9], ids=["steady", "growing", "shrinking"])
def test_a_steady_ripple_on_a_turning_axle_fills_no_memory(growth):
    turned = 2 * np.pi * np.arange(100_000) / 1000
    series = (1 + growth * turned) * (60 * np.cos(turned) + 2 * np.cos(25.4 * turned))
    count = Rainflow(1, CURVE)
    count.push(series[np.newaxis] * MPA)
    assert count.spectrum.forced[0] == 0
    assert count.state.counts[0, DEPTH] < CAPACITY / 2
    assert count.spectrum.damage[0, 0] == pytest.approx(damage(three_point(series.tolist())), rel=1e-6)


def test_a_signal_that_does_not_leave_the_gate_has_no_cycle():
    series = (0.02 * (-1.0) ** np.arange(1001) + 50).tolist()
    spectrum = counted(series, gate=0.05)
    assert spectrum.cycles[0] == 0.0
    assert spectrum.merged[0] == pytest.approx(500, abs=1)
    assert spectrum.merged_at_most[0, 0] == pytest.approx(spectrum.merged[0] * damage([(0.05, 2)]))


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match=r"gate = 1e\+07 Pa is out of range: give 0 to 5e\+06 Pa"):
        Rainflow(1, CURVE, 1e7)
    with pytest.raises(InputError, match="the saved count has no stresses of shape"):
        Rainflow(1, CURVE).resume(Rainflow(2, CURVE).saved())


def test_extremes_beyond_the_matrix_are_in_its_last_cells():
    spectrum = counted([0, 1e300, -1e300, 0])
    assert spectrum.half_cycles[0, -1].sum() == spectrum.half_cycles.sum() == 3
