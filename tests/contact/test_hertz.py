import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.contact import HertzContact

E = 115.4e9


def test_sphere_is_the_closed_form():
    contact = HertzContact(0.3, 0.3, E)
    a, b = contact.semi_axes(1e5)
    assert a == pytest.approx((3 * 1e5 * 0.3 / (4 * E)) ** (1 / 3), rel=1e-10)
    assert b == pytest.approx(a, rel=1e-10)
    assert contact.approach(1e5) == pytest.approx(a**2 / 0.3, rel=1e-10)
    assert contact.peak_pressure(1e5) == pytest.approx(1.5e5 / (np.pi * a**2), rel=1e-10)


def test_curvatures_come_back_from_the_pressure():
    # The displacement of Hertz's pressure, integrated numerically, must have the curvatures of the surfaces.
    contact = HertzContact(0.43175, 0.3, E)
    F = 1e5
    (a, b), p0 = contact.semi_axes(F), contact.peak_pressure(F)

    def displacement(x, y):
        # Potential of an elliptic pressure along rays from the point: exact inside, smooth in the angle.
        angle = (np.arange(4000) + 0.5) * np.pi / 4000
        c, s = np.cos(angle), np.sin(angle)
        A = (c / a) ** 2 + (s / b) ** 2
        B = x * c / a**2 + y * s / b**2
        C = 1 - (x / a) ** 2 - (y / b) ** 2
        return p0 / E * np.mean(0.5 * np.pi * (C + B**2 / A) / np.sqrt(A))

    middle = displacement(0.0, 0.0)
    assert middle == pytest.approx(contact.approach(F), rel=1e-9)
    assert middle - displacement(0.5 * a, 0.0) == pytest.approx((0.5 * a) ** 2 / (2 * 0.43175), rel=1e-9)
    assert middle - displacement(0.0, 0.5 * b) == pytest.approx((0.5 * b) ** 2 / (2 * 0.3), rel=1e-9)


@given(st.floats(0.02, 3.0), st.floats(0.02, 3.0), st.floats(1.0, 1e6))
def test_force_inverts_approach_and_axes_swap(rx, ry, force):
    contact = HertzContact(rx, ry, E)
    assert contact.force(contact.approach(force)) == pytest.approx(force, rel=1e-9)
    assert HertzContact(ry, rx, E).semi_axes(force) == pytest.approx(contact.semi_axes(force)[::-1], rel=1e-9)


def test_no_contact_no_force():
    contact = HertzContact(0.43175, 0.3, E)
    assert contact.force(-1e-5) == 0.0
    assert contact.approach(0.0) == 0.0
