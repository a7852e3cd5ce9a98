"""A paused node that is stepped: by steps, chunks and metres, with the numbers of a run without pauses."""

import numpy as np
import pytest

from support.service_calls import assert_gap_free, end
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = [pytest.mark.ros, pytest.mark.slow]


def test_a_paused_node_takes_the_steps_it_is_asked_for(start, client, forces, states):
    from wheelset_track_msgs.srv import Step

    def step(**fields):
        return client.call("step", Step, again=False, **fields)

    node = start(scenario="undamaged", autostart="false", chunk_duration=0.02)
    refused = step(steps=5)
    assert (refused.success, refused.message) == (False, "there is no run: configure the node first")
    assert client.transition("configure")
    taken = [step(steps=1000), step(chunks=2), step(distance=0.5), step()]
    assert [answer.success for answer in taken] == [True] * 4, taken
    chunk = round(0.02 / load_scenario("undamaged").step_period)
    assert [(answer.first_step, answer.next_step) for answer in taken] == [
        (0, 1000),
        (1000, 1000 + 2 * chunk),
        (1000 + 2 * chunk, 1500 + 2 * chunk),
        (1500 + 2 * chunk, 1500 + 3 * chunk),
    ]
    last = taken[-1].next_step
    client.until(lambda: forces and forces[-1].first_step + len(forces[-1].wheel_1) == last)
    assert_gap_free(forces)
    published = np.concatenate([message.wheel_1 for message in forces])
    simulator, expected = Simulator(load_scenario("undamaged")), []
    while simulator.next_step < last:
        expected.append(simulator.advance(last - simulator.next_step).forces[:, 0])
    assert np.array_equal(published, np.concatenate(expected))
    assert client.state() == "inactive"
    client.until(lambda: states[-1].first_step == last and states[-1].status == states[-1].PAUSED)
    for fields, message in (
        ({"steps": 1, "chunks": 1}, "steps and chunks are given: give one of steps, chunks and distance"),
        ({"steps": 10**9}, "1000000000 steps are out of range: give from 1 to 100000000"),
        ({"distance": -1.0}, "distance = -1 m is out of range: give above 0, up to 100000 m"),
    ):
        assert step(**fields).message == message
    assert client.transition("activate")
    assert step(steps=1).message == "the node is running: pause it first"
    end(node)
