import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.contact import ContactGeometry, build_contact_law
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.simulation.passage import first_clear_step, touched

TURN, ORIGIN = 2713, 1800


def law(*defects: Breakout):
    return build_contact_law(defects, ContactGeometry(), 1e-3, TURN, tables=False)


SMOOTH = law()
SIZE_C = law(Breakout("wheel_1", 0.030, 0.024, 0.002))
OTHER_SIDE = law(Breakout("wheel_2", 0.020, 0.016, 0.001, angle=np.pi))


def test_touched_is_the_defect_and_half_the_contact_area_to_either_side() -> None:
    places = np.flatnonzero(touched(SMOOTH, SIZE_C))
    reach = 29 + len(SIZE_C.x) // 2  # at 30 mm from the centre the height is 0 again
    assert set(places) == {place % TURN for place in range(-reach, reach + 1)}


def test_the_same_law_never_waits() -> None:
    assert first_clear_step(SIZE_C, SIZE_C, ORIGIN, ORIGIN) == ORIGIN


@pytest.mark.parametrize(("before", "after"), [(SMOOTH, SIZE_C), (SIZE_C, SMOOTH), (SIZE_C, OTHER_SIDE)])
@given(earliest=st.integers(0, 20_000))
def test_it_waits_for_the_first_clear_step_and_no_longer(before, after, earliest: int) -> None:
    step = first_clear_step(before, after, earliest, ORIGIN)
    blocked = touched(before, after)
    assert not blocked[(step - ORIGIN) % TURN]
    assert all(blocked[(other - ORIGIN) % TURN] for other in range(earliest, step))
    assert step - earliest < 200


def test_what_is_always_in_the_patch_comes_at_once() -> None:
    around = SMOOTH._replace(tread=SMOOTH.tread - 1e-6)
    assert first_clear_step(SMOOTH, around, 77, ORIGIN) == 77
