import numpy as np
import pytest

from wheelset_track_sim.contact import ContactGeometry, Points, RailHead
from wheelset_track_sim.contact.profiles import gauge_face, inclined
from wheelset_track_sim.errors import InputError


def test_crown_of_60e1_is_smooth_where_arcs_meet():
    head = RailHead()
    for end in head.ends[:-1]:
        below, above = head.drop(end - 1e-9), head.drop(end + 1e-9)
        slope_below = (head.drop(end) - head.drop(end - 1e-6)) / 1e-6
        slope_above = (head.drop(end + 1e-6) - head.drop(end)) / 1e-6
        assert above - below == pytest.approx(0, abs=1e-8)
        assert slope_above == pytest.approx(slope_below, abs=2e-4)


def test_crown_of_60e1_has_the_radii_of_the_standard():
    head = RailHead()
    step = 1e-4
    for y, radius in ((0.003, 0.300), (0.018, 0.080), (0.030, 0.013)):
        slope = (head.drop(y + step) - head.drop(y - step)) / (2 * step)
        bend = (head.drop(y + step) - 2 * head.drop(y) + head.drop(y - step)) / step**2
        assert (1 + slope**2) ** 1.5 / bend == pytest.approx(radius, rel=1e-3)
    # Known points of the drawing: gauge line 14 mm below the top at a width of 72 mm; R80 ends 3 mm below.
    assert head.drop(0.0) == 0.0
    assert head.drop(0.036) == pytest.approx(0.0141, abs=3e-4)
    assert head.drop(0.0361) == np.inf


def test_crown_is_symmetric_and_falls():
    y = np.arange(-72, 73) * 0.0005
    drop = RailHead().drop(y)
    assert (drop == drop[::-1]).all()
    assert (np.diff(drop[72:]) > 0).all()


def test_wheel_is_an_exact_circle():
    geometry = ContactGeometry()
    x = np.linspace(-0.05, 0.05, 11)
    np.testing.assert_allclose(geometry.separation(0, x, 0.0), 0.43175 - np.sqrt(0.43175**2 - x**2), atol=1e-16)


def test_bad_geometry_is_refused():
    with pytest.raises(InputError, match=r"contact\.wheel_radius"):
        ContactGeometry(wheel_radius=-1.0)
    with pytest.raises(InputError, match="radii"):
        RailHead(radii=(0.3, 0.08), ends=(0.02,))
    with pytest.raises(InputError, match="do not reach"):
        RailHead(radii=(0.3, 0.005), ends=(0.01, 0.03))


def points_of(profile, half=0.036, step=5e-4, noise=0.0, seed=0):
    y = np.arange(-round(half / step), round(half / step) + 1) * step
    return Points(y, profile.height(y) + noise * np.random.default_rng(seed).standard_normal(len(y)))


def test_points_of_the_arcs_are_the_arcs():
    # Arcs meet with a jump of curvature, which a spline through points half a millimetre apart follows this far.
    y = np.linspace(-0.025, 0.025, 1001)
    off = points_of(RailHead(), half=0.0355).height(y) - RailHead().height(y)
    assert np.abs(off).max() < 0.3e-6


@pytest.mark.parametrize("noise", [2e-6, 5e-6, 10e-6])
def test_noise_is_taken_out_and_no_curvature_invented(noise):
    head = RailHead((0.3,), (0.036,))
    y = np.linspace(-0.02, 0.02, 401)
    measured = points_of(head, half=0.034, step=2e-4, noise=noise)
    assert np.sqrt(np.mean((measured.height(y) - head.height(y)) ** 2)) < 0.35 * noise
    # Mean curvature over 10 mm, as a contact has it, within a twentieth of that of the arc.
    bend = (
        measured.height(y[100:] - 0.0) - 2 * measured.height(y[100:] - 0.005) + measured.height(y[100:] - 0.01)
    ) / 25e-6
    assert np.abs(bend * 0.3 + 1).max() < 0.05 * noise / 2e-6


def test_steep_sides_are_joined_by_straight_lines():
    y = np.linspace(-0.045, 0.045, 181)
    z = np.where(np.abs(y) < 0.03, -(y**2) / 0.6, -(0.03**2) / 0.6 - 2 * (np.abs(y) - 0.03))
    profile = Points(y, z)
    part = profile.y[profile.running_surface]
    assert 0.027 < part[-1] <= 0.030
    assert -0.030 <= part[0] < -0.027
    assert profile.height(0.04025) == pytest.approx(0.5 * (z[y > 0.0399][0] + z[y > 0.0404][0]), abs=1e-12)
    assert profile.height(0.046) == -np.inf
    assert profile.open_ends == (False, False)


def test_inclined_rail_leans_to_the_middle():
    # A circle stays a circle: its top moves outwards by R sin, up by R (1 - cos).
    round_head = RailHead((0.3,), (0.03,))
    leaning = inclined(round_head, 1 / 20)
    angle = np.arctan(1 / 20)
    y = np.linspace(-0.025, 0.025, 51)
    centre = 0.3 * np.sin(angle), -0.3 * np.cos(angle)
    expected = centre[1] + np.sqrt(0.3**2 - (y - centre[0]) ** 2)
    np.testing.assert_allclose(leaning.height(y), expected, atol=1e-9)
    assert inclined(round_head, 0.0) is round_head


@pytest.mark.parametrize("tangent", [0.0, 1 / 40, 1 / 20])
def test_gauge_is_measured_14_mm_below_the_top(tangent):
    # 60E1 is 36 mm wide to either side there; a leaning head goes inwards by what it is deep.
    assert gauge_face(inclined(RailHead(), tangent)) == pytest.approx(-0.036 + 0.014 * tangent, abs=4e-4)
    with pytest.raises(InputError, match=r"14 m|0\.014 m below"):
        gauge_face(RailHead((0.3,), (0.036,)))


@pytest.mark.parametrize(
    ("y", "z", "words"),
    [
        (np.linspace(-0.03, 0.03, 10), np.zeros(10), "10 y and 10 z"),
        (np.linspace(-0.03, 0.03, 50), np.zeros(49), "50 y and 49 z"),
        (np.linspace(-0.03, 0.03, 50), np.full(50, np.nan), "point 0 .* not finite"),
        (np.linspace(0.03, -0.03, 61), np.zeros(61), "does not rise"),
        (np.r_[-0.03, -0.03, np.linspace(-0.029, 0.03, 60)], np.zeros(62), "of point 1 does not rise"),
        (np.linspace(-0.03, 0.03, 25), np.zeros(25), "apart: give points at most 0.002 m apart"),
        (np.linspace(-0.02, 0.04, 61), np.zeros(61), "does not cover the running surface"),
    ],
)
def test_points_that_are_no_profile_are_refused(y, z, words):
    with pytest.raises(InputError, match=words):
        Points(y, z)
