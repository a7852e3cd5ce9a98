"""Events in a run: at their steps, whatever the blocks are, and each a revision."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.advancing import advance_to
from support.toy import toy_models, toy_scenario
from wheelset_track_sim.errors import InputError
from wheelset_track_sim.samples.block import SampleBlock
from wheelset_track_sim.scenario import Event, Growth, Scenario, SetPoint
from wheelset_track_sim.simulation.agenda import in_order
from wheelset_track_sim.simulation.changes import OvertakenError
from wheelset_track_sim.simulation.simulator import Simulator
from wheelset_track_sim.simulation.speed import course_of

TURN = 2713
SMALL = {"type": "breakout", "on": "wheel_1", "a": 0.004, "b": 0.008, "h": 0.0002}
GROWING: tuple[dict[str, Any], ...] = (
    {"distance": 0.3, "irregularities": [SMALL]},
    {"step": 700, "speed": 30.0, "acceleration": 8.0},
    {"turn": 0.5, "axle_load": 1.8e5, "torque": 2000.0},
    {"distance": 1.5, "grow": {"key": "irregularities.0.h", "to": 0.0006, "over": 4.0, "steps": 2}},
    {"time": 0.18, "speed": 26.0},
)


def simulator(*events: dict[str, Any], **keys: Any) -> Simulator:
    return Simulator(scenario(*events, **keys), models=toy_models())


def scenario(*events: dict[str, Any], **keys: Any) -> Scenario:
    from wheelset_track_sim.scenario import scenario_from

    return scenario_from({**toy_scenario().to_mapping(), "events": [*events], **keys})


def joined(blocks: list[SampleBlock], name: str) -> np.ndarray:
    if name in ("forces", "stresses"):
        return np.concatenate([getattr(block, name) for block in blocks])
    return np.repeat([getattr(block, name) for block in blocks], [len(block) for block in blocks])


@pytest.fixture(scope="module")
def whole() -> Simulator:
    run = simulator(*GROWING)
    run.blocks = advance_to(run, 3 * TURN, 5000)  # type: ignore[attr-defined]
    return run


def test_each_event_is_a_revision_at_its_step(whole: Simulator) -> None:
    assert [each.revision.number for each in whole.history] == [*range(8)]
    steps = [each.revision.step for each in whole.history]
    assert steps[:5] == [0, 300, 700, 1357, 1500]
    assert 3500 <= steps[5] < 3500 + 40 or 3500 <= steps[6] < 3500 + 40
    assert 5500 <= steps[7] < 5500 + 40
    depths = [each.scenario.irregularities[0].h for each in whole.history[1:]]  # type: ignore[attr-defined]
    assert sorted(set(depths)) == pytest.approx([0.0002, 0.0004, 0.0006], rel=1e-15)
    assert whole.in_force.events == ()
    assert whole.in_force.loads.torque == 2000.0
    assert [each.event is None for each in whole.history] == [True, *[False] * 7]


@pytest.mark.slow
@settings(max_examples=3)
@given(st.lists(st.integers(1, 1500), min_size=1, max_size=8))
def test_any_chunks_give_the_same_bits(whole: Simulator, chunks: list[int]) -> None:
    other, blocks, turn = simulator(*GROWING), [], 0
    while other.next_step < 3 * TURN:
        blocks.append(other.advance(min(chunks[turn % len(chunks)], 3 * TURN - other.next_step)))
        turn += 1
    for name in ("forces", "stresses", "revision", "speed"):
        assert np.array_equal(joined(blocks, name), joined(whole.blocks, name))  # type: ignore[attr-defined]
    assert other.history == whole.history


def test_an_event_does_what_the_same_change_by_a_program_does() -> None:
    with_event = simulator({"step": 500, "axle_load": 1.5e5}, {"step": 900, "speed": 35.0})
    by_hand = simulator()
    forces = joined(advance_to(with_event, 2000), "forces")
    blocks = advance_to(by_hand, 500)
    by_hand.apply(dataclasses.replace(by_hand.scenario, axle_load=1.5e5))
    blocks += advance_to(by_hand, 900)
    by_hand.apply(dataclasses.replace(by_hand.scenario, speed=35.0))
    assert np.array_equal(joined(blocks + advance_to(by_hand, 2000), "forces"), forces)


def test_a_time_is_that_of_the_run_also_on_a_ramp() -> None:
    run = simulator({"time": 0.05, "axle_load": 1.5e5}, acceleration=10.0, speed_plan=[{"time": 0.0, "speed": 40.0}])
    blocks = advance_to(run, 2500)
    assert len({block.speed for block in blocks}) > 1
    step = run.history[-1].revision.step
    assert run.history[-1].event == Event(time=0.05, axle_load=1.5e5)
    times = joined(blocks, "time") + np.concatenate([np.arange(len(b)) * b.step_period for b in blocks])
    assert step == np.flatnonzero(times >= 0.05 - 1e-10)[0]


def test_a_plan_goes_on_until_an_event_sets_the_speed() -> None:
    run = simulator(
        {"step": 300, "axle_load": 1.9e5}, {"step": 600, "speed": 25.0}, speed_plan=[{"time": 1.0, "speed": 40.0}]
    )
    advance_to(run, 301)
    assert run.in_force.speed_plan == (SetPoint(1.0, 40.0),)
    advance_to(run, 601)
    assert run.in_force.speed_plan == ()
    assert run.course.at(700).set_point == 25.0


def test_events_at_a_step_happen_in_the_order_of_the_list() -> None:
    run = simulator(
        {"step": 0, "axle_load": 1.9e5}, {"step": 0, "axle_load": 1.8e5}, {"distance": 0.0, "torque": 500.0}
    )
    run.advance(10)
    assert [each.revision.step for each in run.history] == [0, 0, 0, 0]
    assert (run.in_force.axle_load, run.in_force.loads.torque) == (1.8e5, 500.0)


def test_events_are_scheduled_and_dropped_while_it_runs() -> None:
    run = simulator({"step": 5000, "speed": 20.0})
    run.advance(1000)
    base = run.scenario
    coming = (Event(distance=2.0, axle_load=1.9e5), *base.events)
    revision = run.apply(dataclasses.replace(base, events=coming))
    assert (revision.number, revision.step) == (1, 1000)
    advance_to(run, 2001)
    assert run.history[-1].revision.step == 2000
    with pytest.raises(InputError, match=r"^an event at step 1500 is in the past: the run is at step 2001"):
        run.apply(dataclasses.replace(run.scenario, events=(Event(step=1500, speed=20.0),)))
    run.apply(dataclasses.replace(run.scenario, events=()))
    advance_to(run, 5010)
    assert run.in_force.speed == base.speed


def test_a_change_that_an_event_overtakes_is_refused() -> None:
    run = simulator({"step": 100, "axle_load": 1.9e5})
    base = run.scenario
    advance_to(run, 101)
    with pytest.raises(OvertakenError):
        run.apply(dataclasses.replace(base, speed=30.0), base=base)
    assert run.scenario.axle_load == 1.9e5


def test_the_list_stays_while_an_irregularity_grows() -> None:
    grow = {"distance": 1.0, "grow": {"key": "irregularities.0.h", "to": 0.0006, "over": 4.0}}
    with pytest.raises(InputError, match=r"^event at step 3000: it changes the list .* from 5 m on"):
        simulator(grow, {"step": 3000, "remove": ["wheel_1"]}, irregularities=[SMALL])


def test_order_is_that_of_the_course() -> None:
    plain = scenario()
    events = [Event(time=1.0, speed=20.0), Event(distance=5.0, speed=30.0), Event(turn=1.0, torque=1.0)]
    assert in_order(events, plain, course_of(plain)) == tuple(events[::-1])


def test_the_next_step_of_a_growth_stands_in_its_place() -> None:
    growth = Growth("irregularities.0.h", 0.0006, over=3.0, steps=3)
    run = simulator({"step": 10, "torque": 500.0}, irregularities=[SMALL])
    run.apply(dataclasses.replace(run.scenario, events=(Event(step=5, grow=growth), Event(step=1500, torque=2.0))))
    advance_to(run, 1100)
    assert [str(event) for event in run.scenario.events] == ["event at step 1500", "event at distance 2.005 m"]
