"""Transitions over and over, and those that fail: the state, the stream and what is told of them."""

import signal
import socket
from itertools import pairwise

import pytest

from wheelset_track_sim.bags import read_bag

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

OK, ERROR = 0, 2


def assert_gap_free(chunks):
    for before, after in pairwise(chunks):
        assert after.first_step == before.first_step + before.samples


def by_number(client, label):
    """Whether a transition succeeded that is asked for by its number alone, as lifecycle managers do."""
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState

    number = getattr(Transition, f"TRANSITION_{label.upper()}")
    return client.call("change_state", ChangeState, transition=Transition(id=number)).success


def test_transitions_may_be_repeated(start, client, summaries, reports):
    node = start(scenario="undamaged", autostart="false", real_time_factor=4.0)
    begun = [0]
    for _ in range(3):
        assert client.transition("configure")
        for _ in range(4):
            seen = len(summaries)
            assert client.transition("activate")
            client.until(lambda seen=seen: len(summaries) >= seen + 5)
            assert not client.transition("activate")  # it is: refused, and nothing happens
            assert not by_number(client, "activate")
            assert client.transition("deactivate")
        assert client.transition("cleanup")
        client.until(lambda: reports[-1] == (OK, "unconfigured"))
        begun.append(len(summaries))
    for first, last in pairwise(begun):
        run = summaries[first:last]
        assert run[0].first_step == 0
        assert_gap_free(run)
    assert client.state() == "unconfigured"
    assert client.transition("shutdown")
    assert client.state() == "finalized"
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert "Traceback" not in node.errors


def test_bad_scenario_of_a_parameter_file_ends_the_node(start, tmp_path):
    scenario, parameters = tmp_path / "odd.yaml", tmp_path / "parameters.yaml"
    scenario.write_text("name: odd\nspeed: 30\naxle_load: 2e5\nwheelset: no_such_wheelset\n")
    parameters.write_text(f"/wheelset_track_sim:\n  ros__parameters:\n    scenario: {scenario}\n    autostart: false\n")
    node = start("--ros-args", "--params-file", str(parameters))
    assert node.wait() == 2
    assert "no_such_wheelset" in node.errors
    assert "Traceback" not in node.errors


def test_configuring_succeeds_when_what_hindered_it_is_gone(start, client, summaries, reports):
    """The last step of configuring fails: nothing of the first ones is left behind."""
    pytest.importorskip("prometheus_client")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        node = start(scenario="undamaged", autostart="false", prometheus__port=port)
        for _ in range(2):
            seen = len(reports)
            assert not client.transition("configure")
            assert client.state() == "unconfigured"
            client.until(lambda seen=seen: any(level == ERROR for level, _ in reports[seen:]))
            assert str(port) in reports[-1][1]
        client.until(lambda: client.node.count_publishers(f"{client.name}/summary") == 0)
    assert client.transition("configure")
    assert client.transition("activate")
    client.until(lambda: len(summaries) >= 5)
    assert_gap_free(summaries)
    client.until(lambda: reports[-1] == (OK, "running"))
    assert node.signal(signal.SIGINT) == 0, node.errors
    assert str(port) in node.errors + node.output


def test_bag_that_hindered_activating_is_written_when_it_can_be(start, client, summaries, reports, tmp_path):
    bag = tmp_path / "run"
    bag.write_text("in the way")
    where = {"record__on_start": "true", "record__directory": tmp_path, "record__name": "run"}
    node = start(scenario="undamaged", autostart="false", **where)
    assert client.transition("configure")
    assert not client.transition("activate")
    assert client.state() == "inactive"
    client.until(lambda: any(level == ERROR and str(bag) in message for level, message in reports))
    bag.unlink()
    assert client.transition("activate")
    client.until(lambda: len(summaries) >= 5)
    assert node.signal(signal.SIGINT) == 0, node.errors
    recorded = read_bag(bag)
    assert recorded.steps[0] == 0
    assert len(recorded) >= summaries[-1].first_step + summaries[-1].samples
