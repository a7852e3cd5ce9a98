import numpy as np
import pytest

from wheelset_track_sim.contact import ContactGeometry, RailHead
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
    np.testing.assert_allclose(geometry.separation(x, 0.0), 0.43175 - np.sqrt(0.43175**2 - x**2), atol=1e-16)


def test_bad_geometry_is_refused():
    with pytest.raises(InputError, match=r"contact\.wheel_radius"):
        ContactGeometry(wheel_radius=-1.0)
    with pytest.raises(InputError, match="radii"):
        RailHead(radii=(0.3, 0.08), ends=(0.02,))
    with pytest.raises(InputError, match="do not reach"):
        RailHead(radii=(0.3, 0.005), ends=(0.01, 0.03))
