"""The launch files against recording stand-ins: ``launch_ros`` is only on a real installation."""

import runpy
import sys
from types import ModuleType

import pytest
from test_packaging import ROOT

from wheelset_track_sim.yaml12 import parse


class Recorded:
    def __init__(self, *values, **named):
        self.values, self.named = values, named

    def perform(self, context):
        return context[self.values[0]]


@pytest.fixture
def described(monkeypatch):
    kinds = {
        "launch": ["LaunchContext", "LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
        "ament_index_python": [],
        "ament_index_python.packages": [],
    }
    for name, classes in kinds.items():
        module = ModuleType(name)
        for kind in classes:
            setattr(module, kind, type(kind, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    index = sys.modules["ament_index_python.packages"]
    monkeypatch.setattr(index, "get_package_share_directory", lambda package: str(ROOT), raising=False)

    def described(file):
        *declared, what = runpy.run_path(str(ROOT / "launch" / file))["generate_launch_description"]().values[0]
        return {item.values[0]: item.named["default_value"] for item in declared}, what

    return described


def parameters_of(file):
    return {
        name: content["ros__parameters"] for name, content in parse((ROOT / "config" / file).read_text(), file).items()
    }


def test_node_is_the_installed_one_and_takes_what_is_declared(described):
    arguments, node = described("wheelset_track_sim.launch.py")
    assert node.named["package"] == "wheelset_track_sim"
    assert node.named["executable"] == "node"
    assert (ROOT / "tools" / "node").exists()
    file, given = node.named["parameters"]
    assert {file.values[0], *(value.values[0] for value in given.values())} == set(arguments)
    assert set(given) <= set(parameters_of("node.yaml")["/wheelset_track_sim"])
    assert arguments["params_file"] == str(ROOT / "config" / "node.yaml")


@pytest.mark.parametrize(
    ("wheelsets", "names"),
    [("3", ["wheelset_1", "wheelset_2", "wheelset_3"]), ("leading,trailing", ["leading", "trailing"])],
)
def test_fleet_has_a_node_for_each_wheelset(described, wheelsets, names):
    arguments, build = described("fleet.launch.py")
    nodes = build.named["function"]({**arguments, "wheelsets": wheelsets})
    assert [node.named["name"] for node in nodes] == names
    for node in nodes:
        assert (node.named["package"], node.named["executable"]) == ("wheelset_track_sim", "node")
        taken = {node.named["namespace"].values[0], *(item.values[0] for item in node.named["parameters"])}
        assert {*taken, "wheelsets"} == set(arguments)
    assert arguments["params_file"] == str(ROOT / "config" / "fleet.yaml")


def test_fleet_file_knows_the_nodes_that_it_ships_for(described):
    arguments, build = described("fleet.launch.py")
    sections = parameters_of("fleet.yaml")
    nodes = build.named["function"](arguments)
    assert set(sections) == {"/**", *(f"/{node.named['name']}" for node in nodes)}
    known = set(parameters_of("node.yaml")["/wheelset_track_sim"])
    text = (ROOT / "config" / "node.yaml").read_text()
    for name, section in sections.items():
        for parameter in section:
            of_wheel_1 = parameter.replace("wheel_2", "wheel_1")
            assert parameter in known or f"# {of_wheel_1}:" in text, (name, parameter)
