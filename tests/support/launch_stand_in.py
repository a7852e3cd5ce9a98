"""Stand-ins for ``launch`` and ``launch_ros``, which PyPI does not have: they record what a launch file asks for."""

import runpy
import sys
from types import ModuleType

from ruamel.yaml import YAML

from support.paths import ROOT

KINDS = {
    "launch": ["LaunchContext", "LaunchDescription"],
    "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction"],
    "launch.substitutions": ["LaunchConfiguration"],
    "launch_ros": [],
    "launch_ros.actions": ["Node"],
    "launch_ros.parameter_descriptions": ["ParameterValue"],
}
TYPES = {str: str, float: float, bool: {"true": True, "false": False}.__getitem__}


class Recorded:
    def __init__(self, *values, **named):
        self.values, self.named = values, named

    def perform(self, context):
        return context[self.values[0]]


def install(monkeypatch):
    """Put the stand-ins where the modules are looked for."""
    for name, classes in KINDS.items():
        module = ModuleType(name)
        for kind in classes:
            setattr(module, kind, type(kind, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "wheelset_track_sim.ros.launching", raising=False)


class LaunchFile:
    """A launch file of this project, loaded."""

    def __init__(self, name):
        description = runpy.run_path(str(ROOT / "launch" / name))["generate_launch_description"]()
        *self.declared, self._what = description.values[0]
        self.arguments = {item.values[0]: item.named["default_value"] for item in self.declared}

    def nodes(self, **given):
        """Nodes by full name: the parameters that each is given above its file."""
        assert set(given) <= set(self.arguments), "an argument that --show-args would not show"
        context = self.arguments | given
        return [Launched(item.named, context) for item in self._what.named["function"](context)]


class Launched:
    """What would be started."""

    def __init__(self, named, context):
        assert named["package"] == "wheelset_track_sim"
        self.executable = named["executable"]
        self.namespace = "/" + named["namespace"].strip("/")
        self.name = named["name"]
        self.full_name = f"{self.namespace.rstrip('/')}/{self.name}"
        self.file, *above = named["parameters"]
        self.given = {
            name: TYPES[value.named["value_type"]](value.values[0].perform(context))
            for given in above
            for name, value in given.items()
        }
        self.ros_arguments = named["ros_arguments"]
        self.on_exit = named["on_exit"]

    def command(self, folder):
        """Arguments of the process, as ``launch_ros`` makes them."""
        arguments = ["--ros-args", "-r", f"__node:={self.name}", "-r", f"__ns:={self.namespace}"]
        arguments += ["--params-file", str(self.file), *self.ros_arguments]
        if self.given:
            path = folder / f"{self.full_name.strip('/').replace('/', '_')}.yaml"
            with path.open("w") as stream:
                YAML().dump({self.full_name: {"ros__parameters": self.given}}, stream)
            arguments += ["--params-file", str(path)]
        return arguments
