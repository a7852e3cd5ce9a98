"""The inverse of a contact: the approach at which it bears a force."""

from functools import cache

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from wheelset_track_sim.contact import ContactGeometry, approach_for_force, build_contact_law, force_at
from wheelset_track_sim.irregularities import Breakout, Flat, Roughness

SHAPES = (Breakout("wheel_1", 0.03, 0.024, 0.002), Flat("wheel_1", 0.05), Roughness("wheel_1", seed=3))


@cache
def law(number):
    return build_contact_law((SHAPES[number],), ContactGeometry(), 1e-3, 2713, tables=False)


@given(number=st.sampled_from(range(len(SHAPES))), step=st.integers(-40, 40), force=st.floats(1e3, 4e5))
@example(0, 12, 4071.238307971418)  # where the last step of the search stayed above two units in the last place
@example(0, 20, 19343.081384106223)
@example(1, -21, 14116.365714709093)
@example(1, 18, 108461.94306435663)
@example(2, 293, 269318.725199201)
@pytest.mark.slow
def test_a_contact_bears_the_force_of_its_approach(number, step, force):
    approach = approach_for_force(law(number), 0, step, 0, force)
    assert force_at(law(number), 0, step, 0, approach) == pytest.approx(force, rel=1e-9)
