"""Stress around the axle: at angles, in axes that turn, and in those of the track."""

from __future__ import annotations

import numpy as np
import pytest

from wheelset_track_sim.samples.principal import maximum_principal
from wheelset_track_sim.wheelset.around import Around, angles_of
from wheelset_track_sim.wheelset.stress_points import around_axle

AMPLITUDES = np.array([[0.3, -2.0, 0.1, 0.4, -0.2, 0.7]])
STRESS = np.array([[1.0, 2.0, -3.0, 0.5, -0.4, 0.2]])


@pytest.mark.parametrize("angle", [0.0, 0.8, np.pi / 2, -2.5])
def test_the_vertical_plane_is_harmonic_1_of_the_stress_nodes(angle: float) -> None:
    expected = around_axle(1, angle) @ AMPLITUDES[0]
    assert Around.vertical(AMPLITUDES).at(np.array([angle]))[0] == pytest.approx(expected, abs=1e-15)
    expected = around_axle(0, angle) @ np.where(np.arange(6) < 4, AMPLITUDES[0], 0.0)
    even = Around.even(np.where(np.arange(6) < 4, AMPLITUDES, 0.0))
    assert even.at(np.array([angle]))[0] == pytest.approx(expected, abs=1e-15)


def test_the_horizontal_plane_follows_the_vertical_one_by_a_quarter() -> None:
    """With the sign of the unknowns: -U_r lifts at the bottom, -U_theta pushes it forwards."""
    angles = np.linspace(0.0, 2 * np.pi, 36)
    vertical, horizontal = Around.vertical(AMPLITUDES), Around.horizontal(AMPLITUDES)
    assert horizontal.polar(angles) == pytest.approx(-vertical.polar(angles - np.pi / 2), abs=1e-14)


def test_both_planes_turn_in_quadrature() -> None:
    """Bending of 3 above and 4 in front is 5 somewhere between, once a turn."""
    bent = Around.none(1) + Around(np.zeros((1, 6)), 3 * np.eye(6)[1:2], 4 * np.eye(6)[1:2])
    angles = np.radians(np.arange(0.0, 360.0, 0.1))
    along = bent.polar(angles)[0, 1]
    assert along.max() == pytest.approx(5.0, rel=1e-6)
    assert angles[along.argmax()] == pytest.approx(np.arctan2(4, 3), abs=0.002)
    assert along.mean() == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1.1, np.pi])
def test_a_given_stress_turns_with_the_axle(angle: float) -> None:
    given = Around.of_points(STRESS, np.array([angle]))
    assert given.at(np.array([angle])) == pytest.approx(STRESS)
    elsewhere = given.at(np.array([angle + 2.0]))
    assert maximum_principal(elsewhere) == pytest.approx(maximum_principal(STRESS))
    assert elsewhere[0, 1] == pytest.approx(STRESS[0, 1])


def test_bending_from_one_angle() -> None:
    angles = np.array([0.5])
    whole = Around.vertical(AMPLITUDES)
    again = Around.vertical_of_points(whole.at(angles), angles)
    assert again.cosine == pytest.approx(whole.cosine)
    assert again.sine == pytest.approx(whole.sine)
    top = Around.vertical_of_points(whole.at(np.zeros(1)), np.zeros(1))
    assert top.cosine == pytest.approx(whole.cosine)
    assert not top.sine.any()


def test_angles_of_places() -> None:
    places = np.array([[0.0, 0.3, 0.09], [0.09, 0.0, 0.0], [0.0, -0.5, -0.09]])
    assert angles_of(places) == pytest.approx([0.0, np.pi / 2, np.pi])
