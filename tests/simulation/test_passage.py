import sys
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelset_track_sim.contact import ContactGeometry, build_contact_law
from wheelset_track_sim.contact.law import rolling_surfaces
from wheelset_track_sim.irregularities import Breakout, Harmonic, HeadDefect, Polygon
from wheelset_track_sim.scenario import Scenario, load_scenario
from wheelset_track_sim.simulation.changes import Changes, Condition, Revision
from wheelset_track_sim.simulation.passage import differences, faded, passage

TURN, ORIGIN, LINE = 2713, 1800, 5000


@cache
def law(*shapes):
    return build_contact_law(shapes, ContactGeometry(), 1e-3, TURN, rail_steps=LINE, tables=False)


def polygon(amplitude):
    return Polygon("wheel_1", (Harmonic(2, abs(amplitude), 0.0 if amplitude > 0 else np.pi),))


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
    assert passage(smooth, damaged, ORIGIN - reach, ORIGIN) == ORIGIN + reach + 1
    assert passage(smooth, damaged, ORIGIN - reach - 1, ORIGIN) == ORIGIN - reach - 1


def test_the_same_law_never_waits():
    assert passage(law(polygon(1e-5)), law(polygon(1e-5)), ORIGIN, ORIGIN) == ORIGIN


@pytest.mark.parametrize(
    ("before", "after"),
    [((), (SIZE_C,)), ((SIZE_C,), ()), ((SIZE_C,), (OTHER_SIDE,)), ((), (HOLLOW,)), ((HOLLOW,), (SIZE_C,))],
)
@given(earliest=st.integers(0, 20_000))
def test_it_waits_for_the_first_clear_step_and_no_longer(before, after, earliest):
    before, after = law(*before), law(*after)
    step = passage(before, after, earliest, ORIGIN)
    assert step - earliest < 300
    assert not blocked(before, after, step)
    assert step == earliest or blocked(before, after, step - 1)


def test_what_stays_as_it_is_does_not_count():
    """A defect changes beside a polygon that never leaves the patch: only the defect is waited for."""
    before, after = law(polygon(1e-5)), law(polygon(1e-5), SIZE_C)
    assert ORIGIN < passage(before, after, ORIGIN, ORIGIN) < ORIGIN + 100
    assert passage(before, after, ORIGIN + 500, ORIGIN) == ORIGIN + 500


@given(earliest=st.integers(0, 20_000))
def test_what_is_always_in_the_patch_does_not_wait(earliest):
    assert passage(law(), law(polygon(1e-5)), earliest, ORIGIN) is None


@given(first=st.integers(-20_000, 20_000))
def test_a_fade_begins_with_the_old_surfaces_and_ends_with_the_new_ones(first):
    """Row by row, at the wheel and at the rail; in the middle of it they are the mean of both."""
    geometry, steps = ContactGeometry(), 400
    shapes = (polygon(2e-5), HeadDefect("rail_1", 3.0, 0.030, 0.020, 0.001)), (polygon(-1e-5),)
    old, new = (rolling_surfaces(each, geometry, 1e-3, TURN, LINE) for each in shapes)
    found = faded(old, new, first, steps, ORIGIN)
    row_0 = first - len(found.x)

    def heights(surfaces, step):
        return surfaces.treads[0][(step - ORIGIN) % TURN] + surfaces.rails[0].all()[step % LINE]

    assert len(found.treads[0]) == steps + 2 * len(found.x)
    for step, of in ((row_0, old), (first, old), (first + steps, new), (first + steps + len(found.x) - 1, new)):
        np.testing.assert_array_equal(found.treads[0][step - row_0], heights(of, step))
    middle = first + steps // 2
    mean = (heights(old, middle) + heights(new, middle)) / 2
    np.testing.assert_allclose(found.treads[0][middle - row_0], mean, atol=1e-18)
    assert not found.rails[0].all().any()


def nothing_due(_: Scenario) -> int:
    """Step of the next event: none."""
    return sys.maxsize


def test_a_run_goes_on_while_a_fade_is_made_and_the_fade_begins_after_it() -> None:
    """The run claims blocks of 100 steps while the first two fades are made; the third one is far enough ahead."""
    scenario, smooth, rough = load_scenario("undamaged"), law(), law(polygon(1e-5))
    changes = Changes(Condition(Revision(0, 0), scenario, smooth, np.zeros(2), 0, ORIGIN), ORIGIN)
    assert changes.claim(500, nothing_due) == 500
    begun = []

    def fade(begin: int) -> tuple:
        begun.append(begin)
        changes.claim((600, 900)[len(begun) - 1] if len(begun) < 3 else begin, nothing_due)
        return rough, 200

    revision = changes.add(scenario, rough, np.zeros(2), fade)
    assert begun == [500, 800, 1500]
    assert revision == Revision(1, 1500)
    assert [condition.from_step for condition in changes.due(2000)] == [1500, 1700]
