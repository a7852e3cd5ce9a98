"""Changes of any origin, without ROS: whole or not at all, in order, and known everywhere."""

import dataclasses
import math
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from support.advancing import advance_to
from support.toy import toy_models, toy_scenario
from wheelset_track_sim.bags.tread_damage import damage_fields
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.irregularities import Breakout
from wheelset_track_sim.live.revisions import Revisions
from wheelset_track_sim.scenario import SetPoint, load_scenario
from wheelset_track_sim.simulation.changes import OvertakenError, Revision
from wheelset_track_sim.simulation.simulator import Simulator

BASE = load_scenario("undamaged")
SMALL = Breakout("wheel_1", a=0.010, b=0.008, h=0.0005)


def messages(*breakouts):
    return [SimpleNamespace(**fields) for fields in damage_fields(breakouts)]


@pytest.fixture(scope="module")
def models():
    return Simulator(BASE).models


@pytest.fixture
def simulator(models):
    return Simulator(BASE, models=models)


@pytest.fixture
def followed():
    return []


@pytest.fixture
def revisions(followed):
    return Revisions(BASE, followed.append, lambda stage, fraction: None)


def test_before_a_run_all_is_in_force_from_its_start(revisions, followed, models):
    assert revisions.speed(20.0) == Revision(0, 0)
    assert revisions.damage(messages(SMALL)) == Revision(0, 0)
    assert followed[-1] == revisions.scenario == dataclasses.replace(BASE, speed=20.0, irregularities=(SMALL,))
    simulator = Simulator(revisions.scenario, models=models)
    revisions.attach(simulator)
    assert simulator.revision == 0
    assert simulator.advance(10).speed == 20.0


def test_what_was_accepted_while_a_run_was_built_is_its_first_revision(revisions, simulator):
    revisions.speed(20.0)
    revisions.attach(simulator)
    assert simulator.scenario.speed == 20.0
    block = simulator.advance(10)
    assert (block.first_step, block.revision) == (0, 1)
    with pytest.raises(InputError):
        revisions.speed(500.0)
    assert revisions.newest == Revision(1, 0)


def test_answers_name_the_step_at_which_the_run_changes(revisions, simulator, followed):
    revisions.attach(simulator)
    blocks = [simulator.advance(500)]
    answers = [revisions.damage(messages(SMALL)), revisions.speed(30.0, 2.0), revisions.damage([])]
    assert [answer.number for answer in answers] == [1, 2, 3]
    assert [scenario.speed for scenario in followed] == [BASE.speed, 30.0, 30.0]
    while blocks[-1].revision < 3:
        blocks.append(simulator.advance(500))
    for answer in answers:
        assert next(block for block in blocks if block.revision >= answer.number).first_step == answer.step
    assert simulator.in_force == revisions.scenario
    assert simulator.in_force.acceleration == 2.0


def test_refusals_leave_all_as_it_was(revisions, simulator, followed):
    revisions.attach(simulator)
    newest = revisions.speed(30.0)
    accepted, told = revisions.scenario, [*followed]
    deep = dataclasses.replace(SMALL, h=0.010)
    for refuse, message in (
        (lambda: revisions.speed(math.nan), r"speed = nan is not finite: give the running speed from 5 to 100 m/s"),
        (lambda: revisions.speed(101.0), r"speed = 101 m/s is out of range: .* from 5 to 100 m/s"),
        (lambda: revisions.speed(31.0, -1.0), r"acceleration = -1 m/s\^2 is out of range: .* from 0\.01 to 10 m/s\^2"),
        (lambda: revisions.speed(31.0, math.inf), r"acceleration = inf is not finite"),
        (
            lambda: revisions.damage([*messages(SMALL), *messages(deep, deep, deep)]),
            r"tread of wheel_1 is 0\.0305 m deep .* 0\.02 m",
        ),
    ):
        with pytest.raises(InputError, match=f"^{message}"):
            refuse()
        assert revisions.newest == newest
    assert revisions.scenario == accepted == simulator.scenario
    assert followed == told


def test_no_change_is_no_revision(revisions, simulator):
    revisions.attach(simulator)
    first = revisions.speed(30.0)
    assert revisions.speed(30.0) == first
    assert revisions.change(lambda scenario: scenario) == first


def test_a_speed_that_is_set_ends_the_plan_also_if_it_is_that_of_the_start(models):
    planned = dataclasses.replace(BASE, speed_plan=(SetPoint(10.0, 40.0),))
    revisions = Revisions(planned, lambda scenario: None, lambda stage, fraction: None)
    revisions.attach(Simulator(planned, models=models))
    assert revisions.change(lambda scenario: dataclasses.replace(scenario, axle_load=180e3)).number == 1
    assert revisions.scenario.speed_plan
    assert revisions.speed(BASE.speed).number == 2
    assert revisions.scenario.speed_plan == ()


def test_a_change_is_broken_off_when_the_node_ends(simulator):
    class Ended(InputError):  # noqa: N818
        pass

    def end(stage, fraction):
        raise Ended("the node ends")

    revisions = Revisions(BASE, lambda scenario: None, end)
    revisions.attach(simulator)
    rare = dataclasses.replace(SMALL, a=0.0123456789)
    with pytest.raises(Ended):
        revisions.damage(messages(rare))
    assert revisions.newest == Revision(0, 0)
    assert revisions.scenario == simulator.scenario == BASE


def test_a_run_that_cannot_take_what_was_accepted_is_not_attached(revisions, simulator):
    other = load_scenario("undamaged", ["step_length=0.0005"])
    stubborn = Revisions(other, lambda scenario: None, lambda stage, fraction: None)
    with pytest.raises(InputError, match="step_length cannot change during a run"):
        stubborn.attach(simulator)
    assert stubborn.speed(30.0) == Revision(0, 0)  # as without a run
    revisions.attach(simulator)
    revisions.speed(30.0)
    revisions.detach()
    assert revisions.speed(31.0) == Revision(0, 0)
    assert simulator.scenario.speed == 30.0


@pytest.mark.slow
def test_two_at_once_end_in_the_order_of_their_revisions(revisions, simulator):
    revisions.attach(simulator)
    answers = {}

    def change(own):
        for number in range(100):
            speed = 20.0 + own + number / 1000
            answers[speed] = revisions.speed(speed)
            with pytest.raises(InputError):
                revisions.speed(math.nan)

    threads = [threading.Thread(target=change, args=[own]) for own in (1, 2)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        simulator.advance(100)
    assert sorted(answer.number for answer in answers.values()) == [*range(1, 201)]
    in_order = sorted(answers, key=lambda speed: answers[speed].number)
    assert simulator.scenario.speed == revisions.scenario.speed == in_order[-1]
    steps = [answers[speed].step for speed in in_order]
    assert steps == sorted(steps)


def test_events_are_known_before_the_next_change(followed):
    scenario = toy_scenario("events=[{step: 100, axle_load: 190e3}]")
    revisions, simulator = Revisions(scenario, followed.append, lambda stage, fraction: None), None
    simulator = Simulator(scenario, models=toy_models())
    revisions.attach(simulator)
    advance_to(simulator, 150)
    assert revisions.scenario.axle_load == 190e3
    with pytest.raises(OvertakenError):
        revisions.change(lambda before: dataclasses.replace(before, acceleration=1.0))
    assert revisions.speed(30.0).number == 2
    assert [scenario.speed for scenario in followed] == [scenario.speed, 30.0]
    assert (simulator.scenario.axle_load, simulator.scenario.speed) == (190e3, 30.0)
    advance_to(simulator, 200)
    revisions.catch_up()  # nothing has happened
    assert len(followed) == 2


def test_events_are_scheduled_in_their_order_and_dropped():
    scenario = toy_scenario("events=[{step: 5000, axle_load: 190e3}]")
    revisions = Revisions(scenario, lambda scenario: None, lambda stage, fraction: None)
    assert revisions.schedule("[{distance: 6.0, speed: 20.0}]", ".") == Revision(0, 0)
    simulator = Simulator(revisions.scenario, models=toy_models())
    revisions.attach(simulator)
    simulator.advance(100)
    assert revisions.schedule("[{time: 0.05, torque: 500.0}]", ".") == Revision(1, 100)
    assert [*map(str, simulator.scenario.events)] == [
        "event at time 0.05 s",
        "event at step 5000",
        "event at distance 6 m",
    ]
    for text, message in (
        ("[{step: 50, speed: 20.0}]", "an event at step 50 is in the past: the run is at step 100"),
        (
            "[{step: 500, set: {irregularities.0.h: 0.001}}]",
            "events.0: irregularities.0.h: the run has no irregularities",
        ),
        ("[{step: 500}]", "events.0: it changes nothing"),
        ("{step: 500}", "events are a dict: give a list"),
    ):
        with pytest.raises(InputError, match=f"^{message}"):
            revisions.schedule(text, ".")
    assert len(simulator.scenario.events) == 3
    assert revisions.schedule("", ".", replace=True).number == 2
    assert simulator.scenario.events == ()


@pytest.mark.slow
def test_events_and_changes_of_two_threads_lose_nothing_and_can_be_made_again(followed):
    """Changes come whenever they do; each event comes at its step, and all of it again gives the same bits."""
    loads = [150e3 + 100.0 * number for number in range(1, 21)]
    events = "".join(f"{{step: {100 * number}, axle_load: {load}}}, " for number, load in enumerate(loads, 1))
    scenario = toy_scenario(f"events=[{events}]", "acceleration=10")
    simulator = Simulator(scenario, models=toy_models())
    revisions = Revisions(scenario, followed.append, lambda stage, fraction: None)
    revisions.attach(simulator)
    made = []

    def change():
        while simulator.next_step < 2200:
            made.append(revisions.speed(25.0 + len(made) % 10))

    thread = threading.Thread(target=change)
    thread.start()
    forces = np.concatenate([block.forces for block in advance_to(simulator, 2200, 30)])
    thread.join()
    history = [each for each in simulator.history if each.revision.step < 2200]
    assert [each.revision.step for each in history if each.event] == [100 * number for number in range(1, 21)]
    assert [each.scenario.axle_load for each in history if each.event] == loads
    assert len(history) - 21 == sum(revision.step < 2200 for revision in dict.fromkeys(made) if revision.number)
    again = Simulator(toy_scenario("acceleration=10"), models=toy_models())
    blocks = []
    for each in history[1:]:
        blocks += advance_to(again, each.revision.step)
        again.apply(dataclasses.replace(each.scenario, events=()), not_before=each.revision.step, exactly=True)
    assert np.array_equal(np.concatenate([block.forces for block in blocks + advance_to(again, 2200)]), forces)
