"""Stress intensity of a crack in a shaft against other published solutions and its limits."""

import numpy as np
import pytest

from wheelset_track_sim.fatigue.crack import geometry_factor

NONE = np.array([1e-6])


def test_a_shallow_crack_is_one_in_a_half_space():
    """1.1215 for the straight front; 1.03 times the penny's 2/pi for the half penny.

    The latter: F.W. Smith, A.F. Emery, A.S. Kobayashi, J. Appl. Mech. 34 (1967) 953-959.
    """
    assert geometry_factor(NONE, 0.0)[0] == pytest.approx(1.1215, rel=0.01)
    assert geometry_factor(NONE, 1.0)[0] == pytest.approx(1.03 * 2 / np.pi, rel=0.015)


def forman_shivakumar(ratio):
    """Circular front that meets the surface at right angles, bending: ASTM STP 905 (1986) 59-74."""
    beta = np.pi / 2 * ratio
    shape = 0.92 * 2 / np.pi / np.cos(beta) * np.sqrt(np.tan(beta) / beta)
    return shape * (0.923 + 0.199 * (1 - np.sin(beta)) ** 4)


def test_a_front_at_right_angles_is_between_two_aspects():
    """Its aspect falls with depth, from 1 in a half-space to a straight front."""
    shallow, deep = np.array([0.001, 0.02, 0.05, 0.1]), np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    arcs = forman_shivakumar(shallow)
    assert np.all(geometry_factor(shallow, 1.0) < 1.01 * arcs)
    assert np.all(arcs < 1.01 * geometry_factor(shallow, 0.7))
    arcs = forman_shivakumar(deep)
    assert np.all(geometry_factor(deep, 1.0) < arcs)
    assert np.all(arcs < geometry_factor(deep, 0.4))


def test_flatter_cracks_have_more_and_the_curves_are_smooth():
    ratios = np.linspace(0.0, 0.5, 101)
    curves = np.array([geometry_factor(ratios, aspect) for aspect in np.linspace(0, 1, 11)])
    assert np.all(np.diff(curves, axis=0) < 0)
    assert np.abs(np.diff(curves, 2, axis=1)).max() < 4e-3


def test_the_table_is_met():
    assert geometry_factor(np.array([0.2, 0.5]), 0.5)[0] == pytest.approx(0.739)
    assert geometry_factor(np.array([0.8]), 1.0)[0] == pytest.approx(1.737)
