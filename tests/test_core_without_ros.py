"""Everything but ``wheelset_track_sim.ros`` works where there is no ROS."""

import json
import subprocess
import sys

import pytest

BLOCKED = """
import sys

class NoRos:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top in {"rclpy", "rcl_interfaces", "launch", "launch_ros", "ament_index_python"} or top.endswith("_msgs"):
            raise ModuleNotFoundError(f"{name} is blocked", name=top)
        return None

sys.meta_path.insert(0, NoRos())
"""
IMPORTS = """
import importlib, pkgutil, wheelset_track_sim
names = [item.name for item in pkgutil.walk_packages(wheelset_track_sim.__path__, "wheelset_track_sim.")]
core = [name for name in names if not name.startswith("wheelset_track_sim.ros.") and not name.endswith("__main__")]
for name in core:
    importlib.import_module(name)
try:
    importlib.import_module("wheelset_track_sim.ros.node")
except ModuleNotFoundError:
    print(len(core))
"""
RUN = "from wheelset_track_sim.cli import main; sys.exit(main(sys.argv[1:]))"


def python(code, *arguments):
    command = [sys.executable, "-c", BLOCKED + code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def test_every_module_of_the_core_imports():
    done = python(IMPORTS)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 30


@pytest.mark.slow
def test_a_run_needs_no_ros(tmp_path):
    bag = tmp_path / "run.mcap"
    done = python(RUN, "run", "undamaged", "--duration", "0.1", "--json", "--out", str(bag))
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["steps"] > 2000
    assert bag.stat().st_size > 0


@pytest.mark.parametrize(
    ("arguments", "what"),
    [(["node"], "the node"), (["get"], "get"), (["set", "speed=30"], "set"), (["echo", "x"], "echo")],
)
def test_what_needs_ros_is_refused_in_one_line_without_it(arguments, what):
    done = python(RUN, *arguments)
    assert done.returncode == 2
    assert done.stderr.startswith(f"wheelset-track-sim: {what} needs ROS 2 Jazzy")
    assert len(done.stderr.strip().splitlines()) == 1
