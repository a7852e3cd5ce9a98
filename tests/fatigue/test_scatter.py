"""Scatter of the S-N curve: closed forms, rules, limits."""

import dataclasses
import math
from statistics import NormalDist

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.curve import load_curve
from wheelset_track_sim.fatigue.rainflow import Rainflow
from wheelset_track_sim.fatigue.scatter import ScatteredDamage

CURVE = dataclasses.replace(load_curve("assumed_body"), amplitude_scatter=1.3, survival_probability=0.9)
TURNS, DISTANCE = 50, 100.0


def axle(amplitude, curve=CURVE):
    """One cycle of an amplitude, Pa, every two metres."""
    count = Rainflow(1, curve)
    count.push(amplitude * np.cos(2 * np.pi * np.arange(TURNS * 200 + 1) / 200)[np.newaxis])
    return ScatteredDamage(count.spectrum, 0, curve, DISTANCE)


def test_damage_by_cells_is_that_of_the_count():
    assert axle(90e6).damage("elementary", 1e6) == pytest.approx(5e5 * (90 / 200) ** 5 / 1e6, rel=5e-3)
    assert axle(90e6).damage("original", 1e6) == 0.0


def test_the_band_of_the_elementary_rule_has_its_closed_form():
    """The limit of 2.5 % and 97.5 % of axles about the median, which is 1.3^0.5 above that of 90 % survival."""
    whole = axle(90e6)
    deviation = math.log10(1.3) / (2 * 1.2815516)
    weak, strong = whole.band("elementary", 1e6)
    for damage, sign in ((weak, -1), (strong, 1)):
        factor = 1.3**0.5 * 10 ** (sign * 1.959964 * deviation)
        assert damage == pytest.approx(whole.damage("elementary", 1e6) / factor**5, rel=1e-6)


def test_failure_probability_by_the_elementary_rule_has_its_closed_form():
    whole = axle(90e6)
    for distance in (1e7, 1e8, 3e8):
        deviation = math.log10(1.3) / (2 * 1.2815516)
        expected = NormalDist().cdf(math.log10(whole.damage("elementary", distance)) / 5 / deviation - 1.2815516)
        assert whole.failure_probability("elementary", distance) == pytest.approx(expected, rel=1e-4)
    at_limit = axle(200e6).failure_probability("elementary", 2e6)  # a million cycles of what 90 % survive
    assert at_limit == pytest.approx(0.1, rel=0.02)


def test_below_the_limit_the_rules_are_in_order_and_the_original_one_has_the_weak_axles():
    whole = axle(150e6)
    shares = [whole.failure_probability(rule, 1e12) for rule in ("elementary", "haibach", "original")]
    assert shares[0] >= shares[1] > shares[2]
    # In a life without end, those whose limit is below the amplitude fail.
    deviation = math.log10(1.3) / (2 * 1.2815516)
    below = NormalDist().cdf(math.log10(150 / 200) / deviation - 1.2815516)
    assert shares[2] == pytest.approx(below, rel=0.02)
    assert axle(1e6).failure_probability("original", 1.0) == 0.0


def test_a_curve_without_scatter_is_refused():
    with pytest.raises(InputError, match="curve assumed_body has no amplitude_scatter: give it, with its source"):
        axle(90e6, dataclasses.replace(CURVE, amplitude_scatter=None))
