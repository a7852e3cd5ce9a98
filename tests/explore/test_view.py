"""What the controls say: as text in an address, as a scenario, and from a scenario."""

import dataclasses
import math
import re
from urllib.parse import parse_qsl

import pytest

from support.paths import ROOT
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.explore.view import KINDS, MEANINGS, SLIDERS, Base, View
from wheelset_track_sim.inputs import shipped
from wheelset_track_sim.irregularities import Breakout, Flat
from wheelset_track_sim.scenario import load_scenario


@pytest.fixture(scope="module")
def base():
    return Base.of(load_scenario("damage_wheel_1"))


def read(query, of=None):
    return View.read(dict(parse_qsl(query)), of)


@pytest.mark.parametrize("kind", KINDS)
def test_an_address_holds_all_that_applies(kind):
    view = View(kind=kind, on="wheel_2", speed=70 / 3.6, depth=1.3e-3, worn=0.2, rough=True, level=-4.0, stress="fixed")
    again = read(view.query())
    assert again.query() == view.query()
    assert {name for name in view.shown() if view.applies(name)} == {name for name, _ in parse_qsl(view.query())}
    assert (again.speed, again.rough, again.level, again.stress) == (pytest.approx(70 / 3.6), True, -4.0, "fixed")


def test_numbers_of_an_address_are_in_the_units_of_the_page():
    view = read("kind=breakout&length=60&depth=0.3&speed=100&load=22.5&place=300")
    assert (view.length, view.depth, view.place) == (0.06, 0.0003, 0.3)
    assert view.speed == pytest.approx(27.7777778)
    assert view.load == pytest.approx(22.5e3 * 9.81)


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("speed=400", "speed = 400 km/h is out of range: give the speed from 18 to 360 km/h"),
        ("depth=nan", "depth = nan mm is out of range: give the depth from 0 to 5 mm"),
        ("length=long", "length = 'long' is not a number: give the length in mm"),
        ("kind=hole", "kind = 'hole' is not a known choice"),
        ("sped=30", "did you mean speed?"),
        ("rough=yes", "rough = 'yes' is not a switch: give 0 or 1"),
    ],
)
def test_what_an_address_cannot_say_is_refused_in_one_line(query, words):
    with pytest.raises(InputError) as refusal:
        read(query)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_every_control_has_a_meaning():
    assert {field.name for field in dataclasses.fields(View)} == set(SLIDERS) | set(MEANINGS)
    assert all(slider.low < slider.high and slider.meaning.endswith(".") for slider in SLIDERS.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped.names("scenarios"))
def test_a_shipped_scenario_opens_as_it_is(name):
    scenario = load_scenario(name)
    base = Base.of(scenario)
    found = base.scenario_of(base.begin)
    assert found.speed == pytest.approx(scenario.speed, rel=1e-6)
    assert found.axle_load == pytest.approx(scenario.axle_load, rel=1e-6)
    assert (found.wheelset, found.track, found.loads) == (scenario.wheelset, scenario.track, scenario.loads)
    assert sorted(each.type for each in found.irregularities) == sorted(each.type for each in scenario.irregularities)
    left_out = bool(scenario.speed_plan or scenario.events or scenario.sensors)
    assert left_out == any("left out" in note for note in base.notes)


@pytest.mark.parametrize("item", [Breakout("wheel_2", 0.02, 0.01, 0.001, 0.3), Flat("wheel_1", 0.05, 0.1, -0.2)])
def test_the_damage_of_a_scenario_becomes_that_of_the_controls(item):
    scenario = dataclasses.replace(load_scenario("undamaged"), irregularities=(item,))
    base = Base.of(scenario)
    assert base.scenario.irregularities == ()
    (found,) = base.scenario_of(base.begin).irregularities
    turn = scenario.steps_per_revolution * scenario.step_length
    ahead = (item.angle - found.angle) / (2 * math.pi) * turn
    assert ahead / 0.6 == pytest.approx(round(ahead / 0.6), abs=1e-3 / 0.6)  # whole bays
    assert dataclasses.replace(found, angle=item.angle) == item


def test_a_file_of_the_view_meets_the_rail_for_the_first_time_as_the_answer_does(base):
    assert base.scenario_of(base.begin).name == "damage_wheel_1"
    flat = base.scenario_of(read("kind=flat", base.begin))
    assert (flat.name, flat.settle_on) == ("damage_wheel_1, explored", "smooth")
    assert base.scenario_of(read("rough=1", base.begin)).settle_on == "surfaces"


@pytest.mark.parametrize("track", ["ballasted_60e1", "slab_60e1"])
@pytest.mark.parametrize("place", [0.0, 0.3, 0.6])
def test_damage_meets_the_rail_at_its_place_on_the_bay(track, place):
    base = Base.of(load_scenario("undamaged"))
    scenario = base.scenario_of(View(kind="flat", track=track, place=place))
    (flat,) = scenario.irregularities
    meets = scenario.reference_position + flat.angle * scenario.steps_per_revolution * 1e-3 / (2 * math.pi)
    bay = scenario.track.spacing
    assert (meets - place) / bay == pytest.approx(round((meets - place) / bay), abs=1e-6)


def test_another_wheelset_shows_its_own_nodes(base):
    assert base.scenario_of(read("wheelset=metro", base.begin)).output.stress_nodes == ("A1", "B1")
    assert base.scenario_of(base.begin).output.stress_nodes == ("A1", "B1", "C1")
    with pytest.raises(InputError, match="'x41' is not a known wheelset: did you mean x40"):
        base.scenario_of(read("wheelset=x41", base.begin))


def test_a_scenario_that_is_too_slow_is_refused():
    with pytest.raises(InputError, match="dynamics = paper is too slow to explore: give --set dynamics=causal"):
        Base.of(load_scenario("damage_wheel_1", ["dynamics=paper"]))


def test_the_page_of_the_documentation_has_every_control_with_its_range():
    text = (ROOT / "docs" / "howto" / "explore.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*)\|$", text, re.MULTILINE))
    assert [*rows] == [field.name for field in dataclasses.fields(View)]
    for name, slider in SLIDERS.items():
        unit, span, _ = (cell.strip() for cell in rows[name].split(" |"))
        assert (unit, span) == (slider.unit, f"{slider.low:g} to {slider.high:g}"), name
    assert all(f"`{kind}`" in rows["kind"] for kind in KINDS)
