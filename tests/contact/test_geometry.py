import numpy as np
import pytest

from wheelset_track_sim.contact import ContactGeometry, Points, ProfilePair, RailHead, Straight
from wheelset_track_sim.contact.geometry import section
from wheelset_track_sim.errors import InputError

CONE = Straight(1 / 40)


def both(*pair, **named):
    return ContactGeometry(pairs=(ProfilePair(*pair, **named),) * 2)


def test_cone_on_an_upright_rail_touches_where_the_slopes_agree():
    # Closed form on the arc R300: slope -1/40 of the rail at y = -R sin(atan(1/40)), to the inside.
    for shift in (-0.004, 0.0, 0.004):
        geometry = both(CONE, shift=shift)
        inside = 0.300 * np.sin(np.arctan(1 / 40))
        assert geometry.touch(0) == pytest.approx(inside, abs=1e-5)
        assert geometry.touch(1) == -geometry.touch(0)
        assert geometry.rolling_circle(0) == -shift
        assert geometry.rolling_circle(1) == shift
        # Under usual loads the contact is some mm wide: what is steepest within counts.
        angle, at = geometry.pairs[0].angle
        assert np.arctan(1 / 40) < angle < 0.08
        assert at < -inside


def test_cylinder_touches_the_crown_wherever_it_is():
    geometry = both(shift=0.006)
    assert geometry.touch(0) == geometry.touch(1) == 0.0


def test_radius_of_a_cone_counts_at_each_place():
    geometry = both(CONE, RailHead((0.5,), (0.036,)))
    x, y = 0.03, 0.02
    for wheel, outwards in ((0, -0.02), (1, 0.02)):
        radius = 0.43175 - outwards / 40
        at_axle = geometry.separation(wheel, 0.0, y)
        rise = geometry.separation(wheel, x, y) - at_axle
        assert rise == pytest.approx(radius - np.sqrt(radius**2 - x**2), rel=1e-9)


def test_separation_is_zero_where_they_touch_and_mirrored_between_the_sides():
    geometry = both(CONE)
    x, y = np.linspace(-0.02, 0.02, 5)[:, None], np.arange(-30, 31) * 1e-3
    first, second = (geometry.separation(wheel, x, y) for wheel in (0, 1))
    assert (first == second[:, ::-1]).all()
    assert geometry.separation(0, 0.0, geometry.touch(0)) == pytest.approx(0.0, abs=1e-9)
    assert first.min() >= 0.0
    assert geometry.separation(0, 0.0, 0.037) == np.inf


def test_steep_contacts_are_refused():
    with pytest.raises(
        InputError, match=r"wheel_1 touches its rail at an angle of 0\.\d+ rad, .* mm inside.*lateral_off"
    ):
        both(Straight(0.3))
    with pytest.raises(InputError, match="wheel_2 touches its rail at an angle"):
        ContactGeometry(pairs=(ProfilePair(), ProfilePair(Straight(-0.3))))
    y = np.linspace(-0.04, 0.04, 161)
    narrow = Points(y, -(y**2) / 0.8)
    with pytest.raises(InputError, match="off its rail"):
        ProfilePair(narrow, shift=0.2)


def test_section_shows_both_profiles_touching():
    geometry = both(CONE, shift=0.003)
    for wheel, side in ((0, -1), (1, 1)):
        drawn = section(geometry, wheel)
        assert drawn.rolling_circle == side * 0.003
        assert drawn.touch[0] == geometry.touch(wheel)
        distance = drawn.wheel - drawn.rail
        lowest = int(np.nanargmin(distance))
        assert drawn.y[lowest] == pytest.approx(drawn.touch[0], abs=2e-4)
        assert distance[lowest] == pytest.approx(0.0, abs=1e-7)
        assert drawn.rail[lowest] == pytest.approx(drawn.touch[1], abs=1e-5)
        assert np.nanmax(drawn.rail) == pytest.approx(0.0, abs=1e-9)
        assert np.isnan(drawn.rail[0])
        # The radius of a cone falls outwards: its tread rises there.
        assert np.polyfit(side * drawn.y, drawn.wheel, 1)[0] == pytest.approx(1 / 40)
