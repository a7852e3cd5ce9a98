"""Layouts, aggregator and policy speak of topics, fields and services that exist."""

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from rosbags.interfaces import Nodetype

from support.paths import ROOT
from wheelset_track_sim.bags.definitions import full_name, typestore
from wheelset_track_sim.bags.messages import chunk_messages, state_message
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.monitoring.limits import Limits
from wheelset_track_sim.monitoring.monitor import Monitor

CONFIG = ROOT / "config"
NODE = "/wheelset_track_sim"


@pytest.fixture
def kinds(make_block, make_state):
    """Type by topic of all that the node publishes below its name."""
    block = make_block(0, 10)
    messages = [*chunk_messages(block, 0), state_message(make_state(block), 0)]
    sensors = {"axle_box_acceleration": "AxleBoxAcceleration", "suspension_force": "SuspensionForce"}
    others = {"impacts": "WheelImpact", "sensor_summary": "SensorSummary", **sensors}
    return {message.topic: message.kind for message in messages} | others


def field_of(kinds, topic, path):
    """Kind of a field, such as ``scalar`` or ``array``, at a path as viewers write it; KeyError if there is none."""
    name = full_name(kinds[topic])
    for part in path:
        found = re.fullmatch(r"(\w+)(\[(\d+|:)\])?", part)
        of = dict(typestore().fielddefs[name][1])[found[1]]
        array = of[0] in (Nodetype.SEQUENCE, Nodetype.ARRAY)
        assert array == bool(found[2]), f"{part} of {name}: index and array do not match"
        kind, detail = of[1][0] if array else of
        if kind == Nodetype.NAME:
            name = detail
    return found[3] if array else "scalar"


def test_foxglove_layout_names_what_the_node_publishes(kinds):
    layout = json.loads((CONFIG / "layouts" / "foxglove.json").read_text())
    panels = layout["configById"]
    paths = []
    for name, panel in panels.items():
        if name.startswith("Plot!"):
            assert panel["paths"]
            axis = [panel["xAxisPath"]] if "xAxisPath" in panel else []
            paths += [(panel["xAxisVal"], item["value"]) for item in [*panel["paths"], *axis]]
        elif name.startswith("Gauge!"):
            paths.append(("timestamp", panel["path"]))
        elif name.startswith("Diagnostic"):
            assert panel["topicToRender"] == "/diagnostics"
        elif name.startswith("RawMessages!"):
            assert panel["topicPath"].removeprefix(f"{NODE}/") in kinds
    assert len(paths) > 20
    for axis, path in paths:
        if path.replace(".", "").isdigit():
            continue  # a line of reference
        topic, *fields = path.removeprefix(f"{NODE}/").split(".")
        index = field_of(kinds, topic, fields)
        assert (index == ":") == (axis == "index"), path


def test_every_panel_of_the_foxglove_layout_has_its_place():
    layout = json.loads((CONFIG / "layouts" / "foxglove.json").read_text())

    def panels_in(part):
        if isinstance(part, str):
            yield part
        else:
            yield from panels_in(part["first"])
            yield from panels_in(part["second"])

    tabs = layout["configById"]["Tab!main"]["tabs"]
    shown = [name for tab in tabs for name in panels_in(tab["layout"])]
    assert layout["layout"] == "Tab!main"
    assert sorted([*shown, "Tab!main"]) == sorted(layout["configById"])


def test_plotjuggler_layout_names_what_the_node_publishes(kinds):
    root = ET.parse(CONFIG / "layouts" / "plotjuggler.xml").getroot()
    curves = [curve.attrib["name"] for curve in root.iter("curve")]
    assert len(curves) > 15
    for curve in curves:
        assert curve.startswith(f"{NODE}/")
        topic = next(topic for topic in kinds if curve.startswith(f"{NODE}/{topic}/"))
        assert field_of(kinds, topic, curve.removeprefix(f"{NODE}/{topic}/").split("/")) != ":"
    for topic in root.iter("topic"):
        assert topic.attrib["name"].removeprefix(f"{NODE}/") in kinds
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.attrib["count"]) == len(splitter) == len(splitter.attrib["sizes"].split(";"))


def test_the_aggregator_has_a_place_for_every_subject():
    analyzers = parse((CONFIG / "diagnostic_aggregator.yaml").read_text(), "analyzers")["/**"]["ros__parameters"]
    groups = [item for item in analyzers.values() if isinstance(item, dict)]
    assert {item["type"] for item in groups} == {"diagnostic_aggregator/GenericAnalyzer"}
    subjects = [status.name for status in Monitor(("A1", "B1", "C1"), 2e5, Limits(), 2713, np.zeros((3, 6))).report()]
    for subject in [*subjects, "verdict", "simulation", "recording", "services"]:
        places = [item["path"] for item in groups if any(text in f"node: {subject}" for text in item["contains"])]
        assert len(places) == 1, subject


def test_the_policy_has_the_structure_that_sros2_reads():
    """Elements and attributes of SROS2's policy schema, version 0.2.0."""
    root = ET.parse(CONFIG / "sros2" / "policy.xml").getroot()
    assert (root.tag, root.attrib) == ("policy", {"version": "0.2.0"})
    assert [child.tag for child in root] == ["enclaves"]
    enclaves = list(root[0])
    assert [enclave.attrib["path"] for enclave in enclaves] == [NODE, f"{NODE}/operator", f"{NODE}/observer"]
    for enclave in enclaves:
        (profiles,) = enclave
        assert profiles.tag == "profiles"
        for profile in profiles:
            assert (profile.tag, profile.attrib) == ("profile", {"ns": "/", "node": "wheelset_track_sim"})
            for group in profile:
                rules = {"topics": ("publish", "subscribe"), "services": ("reply", "request")}[group.tag]
                assert set(group.attrib) <= set(rules)
                assert set(group.attrib.values()) == {"ALLOW"}
                assert {item.tag for item in group} == {group.tag.removesuffix("s")}
                names = [item.text for item in group]
                assert len(set(names)) == len(names)
                assert all(re.fullmatch(r"[~/][\w/]*", name) for name in names)


def allowed(enclave, kind, rule):
    root = ET.parse(CONFIG / "sros2" / "policy.xml").getroot()
    found = root.findall(f"./enclaves/enclave[@path='{enclave}']/profiles/profile/{kind}[@{rule}='ALLOW']/*")
    return {item.text for item in found}


def test_the_policy_lets_the_node_publish_and_others_watch(kinds):
    topics = {f"~/{topic}" for topic in kinds}
    assert topics <= allowed(NODE, "topics", "publish")
    for watcher in ("operator", "observer"):
        assert topics <= allowed(f"{NODE}/{watcher}", "topics", "subscribe")
    commands = {"~/cmd/speed", "~/cmd/torque", "~/cmd/tread_damage"}
    assert commands <= allowed(f"{NODE}/operator", "topics", "publish")
    assert not allowed(f"{NODE}/observer", "topics", "publish") & commands
    changing = {"~/set_parameters", "~/change_state", "~/set_tread_damage", "~/start_recording"}
    assert changing <= allowed(NODE, "services", "reply")
    assert changing <= allowed(f"{NODE}/operator", "services", "request")
    assert not changing & allowed(f"{NODE}/observer", "services", "request")
