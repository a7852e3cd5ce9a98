from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.contact import ContactGeometry, build_contact_law
from wheelset_track_sim.irregularities import Breakout, Harmonic, HeadDefect, Polygon
from wheelset_track_sim.simulation.passage import differences, passage

TURN, ORIGIN, LINE = 2713, 1800, 5000


@cache
def law(*shapes):
    return build_contact_law(shapes, ContactGeometry(), 1e-3, TURN, rail_steps=LINE, tables=False)


POLYGON = Polygon("wheel_1", (Harmonic(2, 1e-5),))
SIZE_C = Breakout("wheel_1", 0.030, 0.024, 0.002)
OTHER_SIDE = Breakout("wheel_2", 0.020, 0.016, 0.001, angle=np.pi)
HOLLOW = HeadDefect("rail_2", 3.0, 0.030, 0.020, 0.001)


def blocked(before, after, step):
    """Whether anything within the area at a step differs, element by element."""
    reach = max(len(before.x), len(after.x)) // 2
    return np.abs(differences(before, after, step - reach, 2 * reach + 1, ORIGIN)).max() > 1e-15


def test_blocked_is_the_defect_and_half_the_contact_area_to_either_side():
    smooth, damaged = law(), law(SIZE_C)
    reach = 29 + len(damaged.x) // 2  # at 30 mm from the centre the height is 0 again
    assert passage(smooth, damaged, ORIGIN - reach, ORIGIN) == (ORIGIN + reach + 1, True)
    assert passage(smooth, damaged, ORIGIN - reach - 1, ORIGIN) == (ORIGIN - reach - 1, True)


def test_the_same_law_never_waits():
    assert passage(law(POLYGON), law(POLYGON), ORIGIN, ORIGIN) == (ORIGIN, True)


@pytest.mark.parametrize(
    ("before", "after"),
    [((), (SIZE_C,)), ((SIZE_C,), ()), ((SIZE_C,), (OTHER_SIDE,)), ((), (HOLLOW,)), ((HOLLOW,), (SIZE_C,))],
)
@given(earliest=st.integers(0, 20_000))
def test_it_waits_for_the_first_clear_step_and_no_longer(before, after, earliest):
    before, after = law(*before), law(*after)
    step, clear = passage(before, after, earliest, ORIGIN)
    assert clear
    assert step - earliest < 300
    assert not blocked(before, after, step)
    assert step == earliest or blocked(before, after, step - 1)


def test_what_stays_as_it_is_does_not_count():
    """A defect changes beside a polygon that never leaves the patch: only the defect is waited for."""
    before, after = law(POLYGON), law(POLYGON, SIZE_C)
    step, clear = passage(before, after, ORIGIN, ORIGIN)
    assert clear
    assert ORIGIN < step < ORIGIN + 100
    assert passage(before, after, ORIGIN + 500, ORIGIN) == (ORIGIN + 500, True)


@given(earliest=st.integers(0, 20_000))
def test_what_is_always_in_the_patch_changes_within_a_turn_where_it_differs_least(earliest):
    smooth, polygonal = law(), law(POLYGON)
    step, clear = passage(smooth, polygonal, earliest, ORIGIN)
    assert not clear
    assert 0 <= step - earliest < TURN
    # A polygon of second order has four places of no height.
    assert abs(polygonal.tread[0, (step - ORIGIN) % TURN, 0]) < 1e-7
