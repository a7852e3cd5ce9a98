"""Events of a scenario: read whole, refused by name, and what each makes of the scenario in force."""

import dataclasses
from typing import Any

import pytest

from wheelset_track_sim.errors import InputError, InputWarning
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.scenario import Event, Growth, Scenario, load_scenario, scenario_from
from wheelset_track_sim.scenario.events import listed_events

FLAT = {"type": "flat", "on": "wheel_2", "length": 0.03}
BREAKOUT = {"type": "breakout", "on": "wheel_1", "a": 0.02, "b": 0.01, "h": 0.001}


def scenario(*events: dict[str, Any], **keys: Any) -> Scenario:
    data = {"name": "eventful", "speed": 30.0, "axle_load": 2e5, "irregularities": [BREAKOUT], "events": [*events]}
    return scenario_from({**data, **keys})


def happened(event: dict[str, Any], **keys: Any) -> Scenario:
    before = scenario({"step": 1, **event}, **keys)
    changed, following = before.events[0].at(before, 1)
    assert following is None
    return dataclasses.replace(before, **changed, events=())


def test_events_in_a_file_are_si_numbers_that_can_be_read_again() -> None:
    found = scenario(
        {"time": "2 min", "speed": "100 km/h"},
        {"distance": "1 km", "set": {"irregularities.0.h": "1.5 mm"}},
        {"turn": 400, "grow": {"key": "irregularities.0.h", "to": "2 mm", "over": "500 m"}, "axle_load": "22.5 t"},
        {"turn": 401, "replace": {0: FLAT}, "add": [BREAKOUT], "record": "start", "snapshot": True},
    )
    assert found.events[0] == Event(time=120.0, speed=1e5 / 3600)
    assert found.events[1].set == (("irregularities.0.h", 0.0015),)
    assert found.events[2].grow == Growth("irregularities.0.h", 0.002, over=500.0)
    assert found.events[2].axle_load == 220725.0
    assert scenario_from(parse(found.to_yaml(), "it")) == found
    assert found.to_mapping()["events"][0] == {"time": 120.0, "speed": 1e5 / 3600}
    assert str(found.events[0]), found.events[1].what == ("event at time 120 s", ("set",))


def test_a_scenario_without_events_reads_as_before() -> None:
    assert load_scenario("undamaged").events == ()


def test_an_event_changes_what_it_names() -> None:
    assert happened(
        {"speed": 20.0, "acceleration": 1.0}, speed_plan=[{"time": 5.0, "speed": 40.0}]
    ) == dataclasses.replace(scenario(), speed=20.0, acceleration=1.0)
    braked = happened({"torque": -500.0}, loads={"torque_plan": [{"time": 1.0, "torque": 100.0}]})
    assert (braked.loads.torque, braked.loads.torque_plan) == (-500.0, ())
    assert happened({"axle_load": 1.5e5}).axle_load == 1.5e5
    two = [BREAKOUT, FLAT]
    names = [item.type for item in happened({"add": [FLAT]}).irregularities]
    assert names == ["breakout", "flat"]
    assert happened({"irregularities": []}).irregularities == ()
    assert [item.type for item in happened({"remove": [0]}, irregularities=two).irregularities] == ["flat"]
    assert [item.type for item in happened({"remove": ["wheel_2"]}, irregularities=two).irregularities] == ["breakout"]
    assert [item.type for item in happened({"replace": {0: FLAT}}, irregularities=two).irregularities] == ["flat"] * 2
    deeper = happened(
        {"set": {"irregularities.0.h": 0.002, "irregularities.0.a": 0.03}, "remove": [1]}, irregularities=two
    )
    assert deeper.irregularities == (Breakout("wheel_1", a=0.03, b=0.01, h=0.002),)


def test_values_that_belong_together_are_set_together() -> None:
    """Either alone would reach beyond the tread."""
    wide = {**BREAKOUT, "b": 0.04, "y": 0.01}
    moved = happened({"set": {"irregularities.0.b": 0.005, "irregularities.0.y": 0.045}}, irregularities=[wide])
    assert moved.irregularities[0].y == 0.045  # type: ignore[attr-defined]


def test_a_growth_takes_the_values_of_its_law() -> None:
    grow = {"key": "irregularities.0.h", "to": 0.003, "over": 40.0, "steps": 4, "exponent": 0.5}
    now = scenario({"distance": 10.0, "grow": grow})
    found = []
    event: Event | None = now.events[0]
    while event is not None:
        step = round((event.distance or 0.0) / now.step_length)
        changed, event = event.at(now, step)
        now = dataclasses.replace(now, **changed, events=() if event is None else (event,))
        found.append((step, now.irregularities[0].h))  # type: ignore[attr-defined]
        assert scenario_from(parse(now.to_yaml(), "it")) == now  # also under way
    law = [0.001 + 0.002 * (done / 4) ** 0.5 for done in range(5)]
    assert [step for step, _ in found] == [10000, 20000, 30000, 40000, 50000]
    assert [h for _, h in found] == pytest.approx(law, rel=1e-15)
    assert found[-1][1] == 0.003


@pytest.mark.parametrize(
    ("events", "message"),
    [
        ([{"time": 1.0, "step": 5, "speed": 20.0}], "events.0: it has time and step: give one of time, step, distance"),
        ([{"speed": 20.0}], "events.0: it has no time: give one of"),
        ([{"time": 1.0}], "events.0: it changes nothing: give speed, acceleration, axle_load, torque"),
        ([{"time": 2.0, "speed": 20.0}, {"time": 1.0, "speed": 9.0}], "events.1.time = 1 comes before events.0.time"),
        ([{"distance": 9.0, "speed": 20.0}, {"turn": 2, "speed": 30.0}], "events.1.turn = 2 comes before events.0"),
        ([{"time": -1.0, "speed": 20.0}], "events.0.time = -1 s is out of range: give the time of an event"),
        ([{"time": 1.0, "speed": 200.0}], "events.0.speed = 200 m/s is out of range"),
        ([{"time": 1.0, "sped": 20.0}], "events.0.sped is not a known key: did you mean speed?"),
        ([{"time": 1.0, "remove": [1]}], "events.0: remove = 1: the run has irregularities 0 to 0 then"),
        ([{"time": 1.0, "remove": ["rail_1"]}], "events.0: remove = rail_1: nothing is on rail_1 then"),
        ([{"time": 1.0, "remove": ["rail"]}], "events.0: remove = 'rail' is not an index"),
        ([{"time": 1.0, "remove": [0]}, {"time": 2.0, "remove": [0]}], "events.1: remove = 0: the run has no irr"),
        ([{"time": 1.0, "replace": {3: FLAT}}], "events.0: replace.3: the run has irregularities 0 to 0"),
        ([{"time": 1.0, "replace": [FLAT]}], "events.0.replace is not a mapping of indices"),
        ([{"time": 1.0, "set": {"speed": 20.0}}], "events.0.set = 'speed' is not a value of an irregularity"),
        ([{"time": 1.0, "set": {"irregularities.0.depth": 0.1}}], "events.0: irregularities.0.depth: there is no"),
        ([{"time": 1.0, "set": {"irregularities.0.h": 0.1}}], "events.0: irregularities.0.h = 0.1 m is out of range"),
        ([{"time": 1.0, "set": {"irregularities.0.h": "2 N"}}], "events.0.set.irregularities.0.h = '2 N' is not"),
        ([{"time": 1.0, "irregularities": [], "remove": [0]}], "events.0: irregularities replaces all of them"),
        ([{"time": 1.0, "grow": {"key": "irregularities.0.on", "to": 1, "over": 9}}], "events.0: grow.key = .* a num"),
        ([{"time": 1.0, "grow": {"key": "irregularities.0.h", "to": 1.0, "over": 9.0}}], "events.0: irreg.*h = 1"),
        ([{"time": 1.0, "grow": {"key": "irregularities.0.h", "to": 1.0}}], "events.0.grow.over is missing"),
        ([{"time": 1.0, "record": "pause"}], "events.0.record = 'pause' is not a known choice"),
        ("later", "events = 'later' is not a list"),
        ([{"time": 1.0, "speed": 20.0}] * 501, "events has 501 entries: give at most 500"),
    ],
)  # fmt: skip
def test_what_cannot_happen_is_refused_when_it_is_read(events: Any, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        scenario(events=events)


def test_what_cannot_change_in_a_run_is_refused_when_it_is_read() -> None:
    with pytest.raises(InputError, match=r"^events\.0: speed cannot change in paper dynamics"):
        scenario({"time": 0.1, "speed": 20.0}, dynamics="paper")
    with pytest.raises(InputError, match=r"^events\.0: axle_load cannot change during a run with vehicle\.body_mass"):
        load_scenario("long_wave", ["events=[{time: 1.0, axle_load: 1e5}]"])


def test_an_unusual_number_of_an_event_is_doubted() -> None:
    with pytest.warns(InputWarning, match=r"^events\.0\.speed = 80 is taken as 80 m/s"):
        scenario({"time": 1.0, "speed": 80.0})


def test_files_of_events_lie_below_a_folder() -> None:
    asked = []

    def located(name: str) -> str:
        asked.append(name)
        raise InputError("not there")

    with pytest.raises(InputError, match="not there"):
        listed_events("[{time: 1.0, add: [{type: profile, on: wheel_1, file: ../wheel.csv}]}]", located)
    assert asked == ["../wheel.csv"]
    assert listed_events("", located) == ()
    with pytest.raises(InputError, match="events are a dict: give a list"):
        listed_events("{time: 1.0}", located)
