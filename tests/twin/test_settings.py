"""What a setting makes of the scenarios of a run."""

import pytest

from wheelset_track_sim.errors import InputError
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.twin.run_inputs import with_settings

SMOOTH = load_scenario("undamaged")
BOTH = load_scenario("damage_both")


def test_an_irregularity_is_set_wherever_there_is_one() -> None:
    smooth, both = with_settings([SMOOTH, BOTH], ["irregularities.1.h=0.0003"])
    assert smooth == SMOOTH
    assert [each.h for each in both.irregularities] == [BOTH.irregularities[0].h, 0.0003]


def test_damage_by_the_name_of_the_parameter_is_set_wherever_there_is_a_breakout() -> None:
    smooth, both = with_settings([SMOOTH, BOTH], ["wheel_2.damage.h=0.0003"])
    assert smooth == SMOOTH
    assert [(each.on, each.h) for each in both.irregularities] == [("wheel_1", 0.002), ("wheel_2", 0.0003)]
    assert [each.on for each in with_settings([BOTH], ["wheel_2.damage.h=0"])[0].irregularities] == ["wheel_1"]


def test_a_speed_ends_the_speed_plan() -> None:
    [found] = with_settings([load_scenario("line_speeds")], ["speed=30"])
    assert (found.speed, found.speed_plan) == (30.0, ())


def test_models_may_be_set_too() -> None:
    found = with_settings([SMOOTH, BOTH], ["track.spacing=0.65"])
    assert [each.track.spacing for each in found] == [0.65, 0.65]


@pytest.mark.parametrize(
    ("setting", "reason"),
    [
        ("irregularities.2.h=0.001", "has 2 irregularities at most"),
        ("step_length=0.0005", "step_length cannot be set"),
        ("wheel_1.damage.h=deep", r"wheel_1.damage.h = 'deep'"),
        ("wheel_1.damage.h", "not of the form key=value"),
        ("wheel_1.damage.depth=1", "did you mean|wheel_1.damage.depth"),
        ("speed", "not of the form key=value"),
        ("sped=30", "did you mean speed"),
        ("axle_load=1", "axle_load = 1 N is out of range"),
    ],
)
def test_what_cannot_be_set_is_refused(setting: str, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        with_settings([SMOOTH, BOTH], [setting])


@pytest.mark.parametrize("name", ["flat_fresh", "polygon", "rough_wheel", "undamaged"])
@pytest.mark.parametrize("value", ["h", "a", "angle"])
def test_nothing_is_added_to_a_wheel_that_has_no_breakout(name: str, value: str) -> None:
    """A depth that is set on a flat would be that of a second defect inside it."""
    recorded = load_scenario(name)
    of_wheel = [f"irregularities.{n} is a {i.type}" for n, i in enumerate(recorded.irregularities) if i.on == "wheel_1"]
    with pytest.raises(InputError, match=f"the run has no breakout on wheel_1 .{of_wheel[0] if of_wheel else 'which'}"):
        with_settings([recorded], [f"wheel_1.damage.{value}=0.001"])


def test_all_irregularities_may_be_given() -> None:
    given = "irregularities=[{type: breakout, on: wheel_1, a: 0.03, b: 0.024, h: 0.001}]"
    first, second = with_settings([SMOOTH, load_scenario("flat_fresh")], [given])
    assert first.irregularities == second.irregularities
    assert [each.h for each in first.irregularities] == [0.001]


def test_spaces_around_a_key_do_not_count() -> None:
    assert with_settings([BOTH], ["speed = 30", " wheel_1.damage.h = 0.001"]) == with_settings(
        [BOTH], ["speed=30", "wheel_1.damage.h=0.001"]
    )
