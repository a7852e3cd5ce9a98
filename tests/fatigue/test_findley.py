"""Findley's criterion: closed forms, and the stress of points that turn."""

import dataclasses
import math

import numpy as np
import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.fatigue.findley import Findley, load_findley, turning_stress
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.wheelset.around import POLAR, Around

DUCTILE = Findley("test", "test", bending_limit=200e6, torsion_limit=125e6)
TURN = 2 * np.pi * np.arange(120) / 120
YY, YT, TT = (POLAR.index(name) for name in ("yy", "yt", "tt"))


def path(**components):
    """Stress (6, n) of some components."""
    stress = np.zeros((6, len(TURN)))
    for name, values in components.items():
        stress[POLAR.index(name)] = values
    return stress


def test_the_limits_themselves_are_fully_used():
    assert DUCTILE.usage(path(yy=200e6 * np.cos(TURN))) == pytest.approx(1.0, rel=1e-3)
    assert DUCTILE.usage(path(yt=125e6 * np.cos(TURN))) == pytest.approx(1.0, rel=1e-3)
    assert DUCTILE.usage(path(tt=50e6 * np.cos(TURN))) == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize(("bending", "torsion"), [(100e6, 20e6), (80e6, 60e6), (30e6, 110e6)])
def test_proportional_bending_and_torsion_have_their_closed_form(bending, torsion):
    k, f = DUCTILE.k, DUCTILE.f
    expected = (math.sqrt(1 + k**2) * math.hypot(bending / 2, torsion) + k * bending / 2) / f
    stress = path(yy=bending * np.cos(TURN), yt=torsion * np.cos(TURN))
    assert DUCTILE.usage(stress) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("mean", [-60e6, 40e6, 120e6])
def test_a_mean_stress_has_its_closed_form(mean):
    """Axial stress: the largest over the angle of s/2 sin(2 a) + k (m + s) cos(a)^2."""
    amplitude, k = 90e6, DUCTILE.k
    largest = k * (mean + amplitude)
    expected = (math.hypot(amplitude, largest) + largest) / 2 / DUCTILE.f
    assert DUCTILE.usage(path(yy=mean + amplitude * np.cos(TURN))) == pytest.approx(expected, rel=2e-3)


def test_out_of_phase_shear_is_found_by_brute_force():
    stress = path(yy=90e6 * np.cos(TURN), yt=50e6 * np.sin(TURN), tt=20e6 * np.cos(TURN))
    random = np.random.default_rng(2)
    best = 0.0
    for normal in random.normal(size=(4000, 3)):
        n = normal / np.linalg.norm(normal)
        tensor = np.zeros((len(TURN), 3, 3))
        for row, name in enumerate(POLAR):
            i, j = ("ryt".index(each) for each in name)
            tensor[:, i, j] = tensor[:, j, i] = stress[row]
        traction = tensor @ n
        on_normal = traction @ n
        shear = traction - on_normal[:, np.newaxis] * n
        half = len(TURN) // 2
        chord = np.linalg.norm(shear[:half] - shear[half:], axis=1).max() / 2  # of a path symmetric about its middle
        best = max(best, chord + DUCTILE.k * on_normal.max())
    assert DUCTILE.usage(stress) == pytest.approx(best / DUCTILE.f, rel=6e-3)


def test_points_that_turn_see_what_is_known_around_the_axle():
    """A press fit's hoop stress and a torque stay, bending goes round."""
    added = Around(*np.zeros((3, 1, 6)))
    added.mean[0, [YY, TT, YT]] = 20e6, -40e6, 30e6
    bending = Around(*np.zeros((3, 1, 6)))
    bending.cosine[0, [YY, TT]] = 70e6, 14e6
    for angle in (0.0, 0.4, math.pi):
        shown = (added + bending).at(np.array([angle]))[0]
        found = turning_stress(np.tile(shown, (len(TURN), 1)), angle, added, (TURN + 0.3)[np.newaxis])
        assert found[0] == pytest.approx((added + bending).polar(TURN + 0.3)[0], abs=1.0)


@pytest.mark.parametrize("name", shipped.names("criteria"))
def test_a_shipped_criterion_says_that_it_is_assumed(name):
    criterion = load_findley(name)
    assert criterion.name == name
    assert criterion.assumed
    assert "assumed" in criterion.note


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"source": " "}, "source is empty: say where the limits come from"),
        ({"torsion_limit": 90e6}, r"torsion_limit = 9e\+07 Pa is not between half of bending_limit"),
        ({"torsion_limit": 200e6}, "is not between half of bending_limit and all of it"),
        ({"bending_limit": 0.0}, "bending_limit = 0 Pa is out of range"),
    ],
)
def test_what_cannot_be_is_refused(changes, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(DUCTILE, **changes)
