"""``docs/reference/interface.md`` against running nodes, both ways; ``config/node.yaml`` against the parameters."""

import importlib.util
import re
from typing import NamedTuple

import pytest

from support.paths import ROOT
from wheelset_track_sim.inputs.yaml12 import parse

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]

NODE = "wheelset_track_sim"
PAGE = ROOT / "docs" / "reference" / "interface.md"
NODE_FILE = ROOT / "config" / "node.yaml"
TYPES = {float: "double", int: "integer", bool: "bool", str: "string"}
UNDESCRIBED = {"use_sim_time"}
"""Parameters of every node of which rclpy says nothing."""
SHORTEST = 12
"""Characters of a meaning that says something."""


class Topic(NamedTuple):
    topic: str
    type: str
    direction: str
    qos: str


class Service(NamedTuple):
    service: str
    type: str


class Parameter(NamedTuple):
    parameter: str
    type: str
    range: str
    default: str
    changes: str
    description: str


def rows(heading):
    """Rows of the tables in a section of the page, by their column titles."""
    [section] = re.findall(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    found, titles = [], None
    for line in section.splitlines():
        if not line.startswith("|"):
            titles = None
            continue
        cells = [cell.strip().replace("`", "") for cell in line.strip("|").split("|")]
        if titles is None:
            titles = cells
        elif set(line) - set("|-: "):
            found.append(dict(zip(titles, cells, strict=True)))
    return found


def topics_of_page():
    found = [
        Topic(row["topic"], row["type"], row["direction"], row["QoS"].rpartition(",")[0]) for row in rows("Topics")
    ]
    assert len(found) == len(set(found))
    return set(found)


def parameters_of_page(heading="Parameters"):
    return {
        Parameter(
            row["parameter"],
            row["type"],
            row["range"],
            row["default"],
            row["changes"],
            "" if row["parameter"] in UNDESCRIBED else ", ".join(filter(None, [row["meaning"], row["unit"]])),
        )
        for row in rows(heading)
    }


def relative(name):
    return name.replace(f"/{NODE}/", "~/")


def known(client):
    """The graph as the client sees it, from when the node is in it."""
    client.until(lambda: (NODE, "/") in client.node.get_node_names_and_namespaces())
    return client.node


def topics_of(graph):
    """Topics of the running node with what a subscriber or a publisher must know."""
    found = set()
    for direction, named, ends in (
        ("out", graph.get_publisher_names_and_types_by_node, graph.get_publishers_info_by_topic),
        ("in", graph.get_subscriber_names_and_types_by_node, graph.get_subscriptions_info_by_topic),
    ):
        for name, [kind] in named(NODE, "/"):
            if "/_action/" in name:
                continue
            [qos] = {of_qos(end.qos_profile) for end in ends(name) if end.node_name == NODE}
            found.add(Topic(relative(name), kind, direction, qos))
    return found


def of_qos(profile):
    return f"{profile.reliability.name}, {profile.durability.name}".lower().replace("_", " ")


def services_of(graph):
    found = graph.get_service_names_and_types_by_node(NODE, "/")
    return {Service(relative(name), kind) for name, [kind] in found if "/_action/" not in name}


def standard_services():
    return {Service(row["service"], row["type"]) for row in rows("Standard services of simulators")}


def known_type(kind):
    """Whether the package of a service is installed, and knows it."""
    package, _, name = kind.split("/")
    found = importlib.util.find_spec(package) is not None
    return found and hasattr(importlib.import_module(f"{package}.srv"), name)


def parameters_of(client):
    from rcl_interfaces.srv import DescribeParameters, ListParameters

    names = client.call("list_parameters", ListParameters).result.names
    descriptors = client.call("describe_parameters", DescribeParameters, names=names).descriptors
    return {
        Parameter(name, TYPES[type(value)], range_of(item), shown(value), changes(item), item.description)
        for name, value, item in zip(names, client.get(*names), descriptors, strict=True)
    }


def range_of(descriptor):
    limits = [*descriptor.floating_point_range, *descriptor.integer_range]
    return f"{limits[0].from_value:g} to {limits[0].to_value:g}" if limits else ""


def shown(value):
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (int, float)) else value or '""'


def changes(descriptor):
    return "at the start" if descriptor.read_only else "at any time"


def test_page_is_the_running_node_and_the_running_node_is_the_page(start, client):
    forces = client.collect("contact_forces", "ContactForces")
    start(publish_clock="true")
    client.until(lambda: forces)
    own = {"publish_clock": "false"}  # what this test has set
    running = {item._replace(default=own.get(item.parameter, item.default)) for item in parameters_of(client)}
    assert running == parameters_of_page()
    wanted = {Service(row["service"], row["type"]) for row in rows("Services")}
    wanted |= {item for item in standard_services() if known_type(item.type)}
    assert services_of(known(client)) == wanted
    followed = {item for item in topics_of_page() if (item.topic, item.direction) == ("/clock", "in")}
    assert topics_of(known(client)) == topics_of_page() - followed


def test_page_is_a_running_replay_too(start, client, short_bag):
    start(short_bag, "--start-paused", program="replay", publish_clock="true")
    own = {"publish_clock": "false", "start_paused": "false", "bag": '""'}  # what this test has set
    running = {item._replace(default=own.get(item.parameter, item.default)) for item in parameters_of(client)}
    assert running == parameters_of_page("Parameters of the replay")
    of_every_node = {row["service"] for row in rows("Services") if "parameter" in row["service"]}
    wanted = {Service(row["service"], row["type"]) for row in rows("Services of the replay")}
    if importlib.util.find_spec("rosbag2_interfaces") is None:
        wanted = {item for item in wanted if "rosbag2" not in item.type}
    found = services_of(known(client))
    assert {item for item in found if item.service not in of_every_node | {"~/get_type_description"}} == wanted
    assert of_every_node <= {item.service for item in found}
    recorded = {
        "~/contact_forces",
        "~/axle_stress/a1",
        "~/axle_stress/b1",
        "~/axle_stress/c1",
        "~/summary",
        "~/impacts",
    }
    played = {*recorded, "~/state", "/clock", "/rosout", "/parameter_events"}
    assert topics_of(known(client)) == {
        item for item in topics_of_page() if item.topic in played and item.direction == "out"
    }


def test_clock_is_followed_where_it_is_asked_for(start, client):
    start(use_sim_time="true", autostart="false")
    assert client.get("use_sim_time") == [True]
    [clock] = [item for item in topics_of(known(client)) if item.topic == "/clock"]
    assert clock in topics_of_page()


def test_every_row_of_the_page_says_what_it_is_for():
    for row in rows("Topics"):
        assert row["unit"], row
        assert len(row["content"]) > SHORTEST, row
    for row in rows("Services") + rows("Services of the replay") + rows("Standard services of simulators"):
        assert len(row["what it does"]) > SHORTEST, row
    for row in rows("Parameters") + rows("Parameters of the replay"):
        assert row["type"] != "double" or row["unit"] or "share" in row["meaning"] or "over" in row["meaning"], row


def test_depths_are_those_of_the_code():
    from wheelset_track_sim.bags.topics import DEPTH, LATCHED_TOPICS
    from wheelset_track_sim.ros.services import COMMANDS

    for row in rows("Topics"):
        if "wheelset_track_msgs" in row["type"] or "/cmd/" in row["topic"]:
            latched = row["topic"].removeprefix("~/") in LATCHED_TOPICS
            depth = COMMANDS.depth if row["direction"] == "in" else 1 if latched else DEPTH
            assert row["QoS"].endswith(f", keep last {depth}"), row


def test_parameter_file_has_all_of_them_with_their_defaults_and_comments(start, client):
    start(autostart="false")
    lines = [line for line in NODE_FILE.read_text().splitlines() if re.match(r" {4}\S", line)]
    commented = [line for line in lines if line.lstrip().startswith("# ")]
    for line in lines:
        assert re.fullmatch(r"[^#]+# (\* )?[^*].*", line.lstrip("# ")), f"no comment: {line}"
    file = parse("\n".join(line.replace("# ", "", 1) if line in commented else line for line in lines), NODE_FILE.name)
    fixed = {line.split(":")[0].strip("# ") for line in lines if "# *" in line}
    running = {item.parameter: item for item in parameters_of(client)}
    not_there = {"use_sim_time", "start_type_description_service"}  # of every node
    assert set(file) == {name for name in running if name not in not_there and not name.startswith("wheel_2.")}
    assert {name: shown(value) for name, value in file.items()} == {name: running[name].default for name in file} | {
        "autostart": "true"
    }
    assert fixed == {name for name in file if running[name].changes == "at the start"}
