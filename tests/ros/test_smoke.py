"""The shell of ROS in short: its modules import, and a node streams what the simulator gives until a signal."""

import importlib
import pkgutil
import signal

import numpy as np
import pytest

from support.toy import toy_scenario
from wheelset_track_sim import ros
from wheelset_track_sim.simulation.simulator import Simulator

pytestmark = [pytest.mark.ros, pytest.mark.timeout(120)]


def test_every_module_of_the_shell_imports():
    names = {item.name for item in pkgutil.iter_modules(ros.__path__)} - {"launching"}  # PyPI has no launch
    assert {"node", "process", "replay", "services"} <= names
    for name in sorted(names):
        importlib.import_module(f"wheelset_track_sim.ros.{name}")


def test_a_node_streams_the_bits_of_the_simulator_and_ends_with_a_signal(start, client, forces, tmp_path):
    scenario = toy_scenario(like="damage_wheel_1")
    (tmp_path / "toy.yaml").write_text(scenario.to_yaml(), encoding="utf-8")
    node = start(scenario=tmp_path / "toy.yaml", real_time_factor=0.5)
    client.until(lambda: forces)
    assert node.signal(signal.SIGINT) == 0, node.errors
    chunk = forces[0]
    rows = slice(chunk.first_step, chunk.first_step + len(chunk.wheel_1))
    expected = Simulator(scenario).advance(rows.stop).forces[rows]
    np.testing.assert_array_equal(np.stack([chunk.wheel_1, chunk.wheel_2], axis=-1), expected)
