"""A node whose wheels touch the rails beside the middle of their heads: damage, contact pressure and its bag."""

import signal

import pytest

from wheelset_track_sim.bags import read_bag
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.scenario import load_scenario, scenario_from

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


def test_damage_comes_and_goes_where_the_wheel_runs(start, client, tmp_path):
    from wheelset_track_msgs.srv import GetContactPressure

    bag = {"record__directory": tmp_path, "record__name": "run", "record__on_start": "true"}
    node = start(scenario="lateral_offset", **bag)
    forces = client.collect("contact_forces", "ContactForces")
    client.until(lambda: forces)
    answer = client.call("get_contact_pressure", GetContactPressure, wheel=2, at=0)
    assert answer.success, answer.message
    across = [sum(answer.pressure[column :: answer.columns]) for column in range(answer.columns)]
    at = sum(load * (answer.y0 + column * answer.dy) for column, load in enumerate(across)) / sum(across)
    assert at == pytest.approx(-0.0115, abs=0.002)  # inside the middle of the left rail, towards the gauge corner
    assert client.set(wheel_1__damage__h=0.0).successful
    client.until(lambda: forces[-1].revision == 1)
    seen = len(forces)
    client.until(lambda: len(forces) > seen + 5)
    assert max(max(chunk.wheel_1) for chunk in forces[seen:]) < 108e3
    assert client.set(wheel_1__damage__h=0.0008).successful
    client.until(lambda: forces[-1].revision == 2 and max(forces[-1].wheel_1) > 130e3)
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors
    recorded = scenario_from(parse(read_bag(tmp_path / "run").info.scenario, "the bag"))
    assert recorded.profiles == load_scenario("lateral_offset").profiles
    assert recorded.lateral_offset == 0.003
