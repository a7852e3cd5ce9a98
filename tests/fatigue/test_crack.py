"""Growth of a crack in a shaft: closed forms, bounds, cells of the spectrum."""

import dataclasses

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue import crack
from wheelset_track_sim.fatigue.crack import CrackSpectrum, crack_life, growth_per_metre
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.growth import load_crack_growth
from wheelset_track_sim.fatigue.rainflow import Rainflow

STEEL = load_crack_growth("assumed_steel")
PLAIN = dataclasses.replace(STEEL, threshold=0.0)
DIAMETER = 0.18
CIRCUMFERENCE = 2.7


def turning(amplitude, mean=0.0):
    """One cycle a turn."""
    return CrackSpectrum(np.array([2 * amplitude]), np.array([mean]), np.array([1 / CIRCUMFERENCE]))


def test_paris_with_a_constant_factor_has_its_closed_form(monkeypatch):
    """N = (a_1^(1 - m/2) - a_0^(1 - m/2)) / ((1 - m/2) C (F S sqrt(pi))^m), and a logarithm for m = 2."""
    monkeypatch.setattr(crack, "geometry_factor", lambda ratio, aspect: np.full_like(ratio, 0.7))
    for exponent in (2.0, 3.0, 4.2):
        law = dataclasses.replace(PLAIN, exponent=exponent, toughness=25e6)
        life = crack_life(turning(80e6), law, 0.002, DIAMETER)
        assert life.fractures
        end = life.depth[-1]
        assert end == pytest.approx((25e6 / (0.7 * 80e6)) ** 2 / np.pi, rel=1e-3)
        power = 1 - exponent / 2
        integral = np.log(end / 0.002) if exponent == 2 else (end**power - 0.002**power) / power
        cycles = integral / (law.rate * (0.7 * 80e6 * np.sqrt(np.pi) / law.reference_range) ** exponent)
        assert life.left == pytest.approx(cycles * CIRCUMFERENCE, rel=1e-4)


def test_growth_cycle_by_cycle_is_the_integral_over_the_spectrum():
    """Two kinds of cycles by turns, one after the other, each growing the crack a little."""
    law = dataclasses.replace(PLAIN, rate=1e-7, toughness=30e6)
    kinds = [turning(80e6), turning(60e6, mean=10e6)]
    half = [CrackSpectrum(each.span, each.mean, each.per_metre / 2) for each in kinds]
    both = CrackSpectrum(
        *(np.concatenate(pair) for pair in zip(vars(half[0]).values(), vars(half[1]).values(), strict=True))
    )
    life = crack_life(both, law, 0.005, DIAMETER)
    depth, cycles = np.array([0.005]), 0
    while depth[0] < life.depth[-1]:
        depth = depth + CIRCUMFERENCE * growth_per_metre(kinds[cycles % 2], law, depth, DIAMETER)
        cycles += 1
    assert 200 < cycles < 500
    assert life.left == pytest.approx(cycles * CIRCUMFERENCE, rel=1e-2)


def test_cycles_add_up():
    one, other = turning(80e6), turning(60e6, mean=15e6)
    both = CrackSpectrum(*(np.concatenate(pair) for pair in zip(vars(one).values(), vars(other).values(), strict=True)))
    depths = np.array([0.002, 0.02, 0.08])
    rates = [growth_per_metre(each, PLAIN, depths, DIAMETER) for each in (one, other, both)]
    assert rates[2] == pytest.approx(rates[0] + rates[1])


def test_below_the_threshold_nothing_grows():
    life = crack_life(turning(40e6), STEEL, 0.002, DIAMETER)
    assert life.left == np.inf
    assert crack_life(turning(40e6), STEEL, 0.02, DIAMETER).left < np.inf


def test_mean_stress_and_a_deep_crack_shorten_what_is_left():
    lives = [crack_life(turning(80e6, mean), PLAIN, 0.002, DIAMETER).left for mean in (-20e6, 0.0, 20e6)]
    assert lives[0] > lives[1] > lives[2]
    assert crack_life(turning(80e6), PLAIN, 0.01, DIAMETER).left < lives[1]
    whole = crack_life(turning(80e6), PLAIN, 0.002, DIAMETER)
    later = np.interp(0.01, whole.depth, whole.distance)
    assert whole.left - later == pytest.approx(crack_life(turning(80e6), PLAIN, 0.01, DIAMETER).left, rel=1e-3)


def test_the_band_is_in_order():
    slow, middle, fast = (
        crack_life(turning(90e6), STEEL.at(end), 0.005, DIAMETER).left for end in ("slow", "middle", "fast")
    )
    assert slow > 2 * middle > 4 * fast


def test_a_depth_that_is_critical_or_out_of_range_is_refused():
    with pytest.raises(InputError, match=r"depth = 0\.1 m is out of range: give more than 0 m, up to 0\.09 m"):
        crack_life(turning(80e6), STEEL, 0.1, DIAMETER)
    with pytest.raises(InputError, match=r"depth = 0\.08 m is critical already: 6\d\.\d MPa"):
        crack_life(turning(200e6), STEEL, 0.08, DIAMETER)


def test_cells_have_the_exact_range_and_mean_of_a_constant_amplitude():
    count = Rainflow(2, load_curve("assumed_body"))
    turned = 2 * np.pi * np.arange(20_000) / 1000
    count.push(np.stack([64.2e6 * np.cos(turned) + 31e6, 30e6 * np.sin(turned)]))
    span, mean, number = count.spectrum.cells(0)
    assert span == pytest.approx(np.full(len(span), 128.4e6), rel=1e-3)
    assert np.average(mean, weights=number) == pytest.approx(31e6, rel=1e-2)
    assert number.sum() == pytest.approx(20, abs=1)
    both = count.spectrum + count.spectrum
    assert both.cells(0)[2].sum() == 2 * number.sum()
    assert both.cells(0)[0] == pytest.approx(span)


def test_the_worst_place_is_where_the_impact_opens_the_crack():
    pulled, pushed = turning(80e6, 12e6), turning(81e6, -12e6)
    assert crack.fastest([pushed, pulled, pushed], STEEL, 0.01, DIAMETER) == 1
