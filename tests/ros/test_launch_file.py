"""The launch file against recording stand-ins: ``launch_ros`` is only on a real installation."""

import runpy
import sys
from types import ModuleType

import pytest
from test_packaging import ROOT

from wheelset_track_sim.yaml12 import parse

FILE = ROOT / "launch" / "wheelset_track_sim.launch.py"


class Recorded:
    def __init__(self, *values, **named):
        self.values, self.named = values, named


@pytest.fixture
def described(monkeypatch):
    kinds = {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument"],
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
    return runpy.run_path(str(FILE))["generate_launch_description"]().values[0]


def test_node_is_the_installed_one_and_takes_what_is_declared(described):
    *declared, node = described
    assert node.named["package"] == "wheelset_track_sim"
    assert node.named["executable"] == "node"
    assert (ROOT / "tools" / "node").exists()
    file, given = node.named["parameters"]
    arguments = {item.values[0]: item.named["default_value"] for item in declared}
    assert {file.values[0], *(value.values[0] for value in given.values())} == set(arguments)
    known = parse((ROOT / "config" / "node.yaml").read_text(), "node.yaml")["/wheelset_track_sim"]["ros__parameters"]
    assert set(given) <= set(known)
    assert arguments["params_file"] == str(ROOT / "config" / "node.yaml")
