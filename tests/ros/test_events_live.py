"""Events of a running node: each a revision, shown by parameters, and a recording that begins and ends by itself."""

import time

import pytest

from support.nodes import PATIENCE
from support.service_calls import assert_gap_free, end

pytestmark = [pytest.mark.ros, pytest.mark.slow]

SCENARIO = """
name: eventful
speed: 27.7777778
axle_load: 196200.0
events:
  - {distance: 3.0, axle_load: 190000.0, record: start}
  - {step: 6000, speed: 30.0}
  - {time: 0.4, record: stop}
"""


def test_events_change_the_run_and_record_a_part_of_it(start, client, tmp_path, forces, states):
    from wheelset_track_msgs.srv import ScheduleEvents

    from wheelset_track_sim.bags import read_bag
    from wheelset_track_sim.twin import resimulate

    file = tmp_path / "eventful.yaml"
    file.write_text(SCENARIO)
    node = start(
        scenario=file, autostart="false", record__directory=tmp_path / "bags", chunk_duration=0.03, duration=3.0
    )
    client.until(lambda: client.state() == "unconfigured")
    assert client.transition("configure")
    assert client.transition("activate")
    client.until(lambda: forces and forces[-1].revision >= 3)
    assert_gap_free(forces)
    answer = client.call("schedule_events", ScheduleEvents, events="[{distance: 60.0, speed: 25.0, acceleration: 2.0}]")
    assert answer.success, answer.message
    refused = client.call("schedule_events", ScheduleEvents, events="[{step: 1, speed: 20.0}]")
    assert not refused.success
    assert refused.message.startswith("an event at step 1 is in the past: the run is at step")
    client.until(lambda: forces[-1].revision >= 5)
    until = time.monotonic() + PATIENCE
    while client.get("axle_load", "speed", "acceleration") != [190000.0, 25.0, 2.0]:
        assert time.monotonic() < until
    end(node)
    steps = {state.revision: state.first_step for state in states}
    assert (steps[1], steps[2], steps[5]) == (3000, 6000, 60000)
    [bag] = (tmp_path / "bags").iterdir()
    recording = read_bag(bag)
    assert recording.steps[0] == 3000
    assert recording.steps[-1] == steps[3] - 1
    assert resimulate(bag).identical
    for told in ("event at distance 3 m (axle_load, record): revision 1 from step 3000", "recording to", "recorded "):
        assert told in node.errors
