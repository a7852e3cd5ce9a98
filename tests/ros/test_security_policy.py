"""The SROS2 policy against the graph of a running node: all that the node does is allowed, and others may use it."""

import re
import xml.etree.ElementTree as ET

import pytest

from support.paths import ROOT

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

POLICY = ROOT / "config" / "sros2" / "policy.xml"
NODE = "wheelset_track_sim"


def allowed(enclave, kind, rule):
    found = ET.parse(POLICY).findall(
        f"./enclaves/enclave[@path='{enclave}']/profiles/profile/{kind}[@{rule}='ALLOW']/*"
    )
    return {item.text.replace("~", f"/{NODE}") for item in found}


def known(client, publishes, serves):
    """Topics published, topics subscribed and services in the domain once some of them are discovered.

    There are but the node and the client in it, whose own services and subscriptions are left out. The graph by node
    would be shorter, but it stays incomplete now and then where a process has had many nodes.
    """
    graph, found = client.node, []

    def complete():
        topics = {name for name, _ in graph.get_topic_names_and_types()}
        services = {name for name, _ in graph.get_service_names_and_types()}
        published = {name for name in topics if graph.count_publishers(name)}
        subscribed = {name for name in topics if graph.count_subscribers(name)}
        own = {subscription.topic_name for subscription in graph.subscriptions}
        client_services = {name for name in services if name.startswith(graph.get_fully_qualified_name() + "/")}
        found[:] = published, subscribed - own, services - client_services
        return publishes <= published and serves <= services

    client.until(complete)
    return found


def test_all_that_the_node_does_is_allowed_and_others_may_use_it(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    start(scenario="damage_wheel_1")
    client.until(lambda: forces)
    own = f"/{NODE}"
    published, subscribed, services = known(
        client, {f"{own}/impacts", "/diagnostics", "/rosout"}, {f"{own}/set_parameters", f"{own}/change_state"}
    )
    assert f"{own}/cmd/speed" in subscribed
    assert published <= allowed(own, "topics", "publish")
    assert subscribed <= allowed(own, "topics", "subscribe")
    assert services <= allowed(own, "services", "reply")
    assert services <= allowed(f"{own}/operator", "services", "request")
    assert subscribed - {"/clock", "/parameter_events"} <= allowed(f"{own}/operator", "topics", "publish")
    for enclave in ("operator", "observer"):
        assert published <= allowed(f"{own}/{enclave}", "topics", "subscribe")


def test_a_replay_under_the_name_of_the_node_may_do_what_it_does(start, client, short_bag):
    start(short_bag, "--start-paused", program="replay", publish_clock="true")
    assert client.get("loop") == [False]
    own = f"/{NODE}"
    published, _, services = known(client, {f"{own}/summary"}, {f"{own}/play_next"})
    assert published <= allowed(own, "topics", "publish")
    assert services <= allowed(own, "services", "reply") & allowed(f"{own}/operator", "services", "request")


@pytest.mark.parametrize(
    ("enclave", "words"),
    [
        ("/wheelset_track_sim", "has no security: use a system installation of ROS 2|ROS does not start: .*security"),
        ("/nowhere", "ROS does not start: .*nowhere' does not exist"),
        ("relative", "ROS does not start: .*must be absolute"),
    ],
)
def test_security_that_cannot_be_had_is_named_in_one_line(start, tmp_path, enclave, words):
    (tmp_path / "enclaves" / NODE).mkdir(parents=True)
    store = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": str(tmp_path)}
    node = start("--ros-args", "--enclave", enclave, env=store)
    assert node.wait() == 2
    [line] = [line for line in node.errors.splitlines() if line.startswith("wheelset-track-sim")]
    assert re.search(words, line)
    assert "Traceback" not in node.errors
