"""What the launch files ask for, and what users remap, as real processes: names of topics, services, diagnostics, bags.

``launch_stand_in`` makes the command lines as ``launch_ros`` does, which PyPI does not have; where ``ros2 launch`` is
installed, it starts them itself.
"""

import shutil
import signal
import subprocess

import numpy as np
import pytest

from support.launch_stand_in import LaunchFile, install
from support.paths import ROOT
from wheelset_track_sim.bags import read_bag

pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.fixture
def view(client):
    """A node by its full name."""

    def view(name):
        other = type(client)(client.node, client.running)
        other.name = name
        return other

    return view


@pytest.fixture
def launch(monkeypatch, start, tmp_path):
    """Nodes of a launch file, started."""

    def launch(file, **given):
        with monkeypatch.context() as patch:
            install(patch)
            nodes = LaunchFile(file).nodes(**given)
        return {node.full_name: start(*node.command(tmp_path)) for node in nodes}

    return launch


def statuses(node, kind="DiagnosticArray"):
    from diagnostic_msgs.msg import DiagnosticArray

    found = []
    node.create_subscription(DiagnosticArray, "/diagnostics", found.append, 100)
    return found


def test_bogie(launch, view, tmp_path):
    views = {name: view(name) for name in ("/bogie/leading", "/bogie/trailing")}
    forces = {name: view.collect("contact_forces", "ContactForces") for name, view in views.items()}
    nodes = launch("bogie.launch.py", record="true", record_directory=str(tmp_path / "bags"), log_level="warn")
    assert set(nodes) == set(views)
    for name, of_node in views.items():
        of_node.until(lambda name=name: forces[name])
        assert forces[name][0].decimation == 10
        depth, folder = (0.002, 0.0)[name.endswith("trailing")], str(tmp_path / "bags")
        assert of_node.get("wheel_1.damage.h", "record.directory", "record.on_start") == [depth, folder, True]
    for node in nodes.values():
        assert node.signal(signal.SIGINT) == 0, node.errors
        assert "[INFO]" not in node.errors + node.output
    bags = sorted(path.name.split("_", 3)[3] for path in (tmp_path / "bags").iterdir())
    assert bags == ["bogie_leading", "bogie_trailing"]


def test_autostart_can_be_left_to_a_lifecycle_manager(launch, view):
    node = view("/test/mine")
    launch("wheelset_track_sim.launch.py", name="mine", namespace="test", autostart="false", scenario="undamaged")
    assert node.state() == "unconfigured"
    assert node.get("scenario", "autostart") == ["undamaged", False]
    forces = node.collect("contact_forces", "ContactForces")
    assert node.transition("configure")
    assert node.transition("activate")
    node.until(lambda: forces)


def test_a_section_of_a_parameter_file_may_be_for_all_nodes_of_a_name(start, view, tmp_path):
    file = tmp_path / "leading.yaml"
    file.write_text("/**/leading:\n  ros__parameters:\n    axle_load: 150000.0\n")
    for name in ("leading", "trailing"):
        names = ["-r", f"__node:={name}", "-r", "__ns:=/train/vehicle_1/bogie_1"]
        start("--ros-args", *names, "--params-file", str(file), scenario="undamaged", autostart="false")
    assert view("/train/vehicle_1/bogie_1/leading").get("axle_load") == [150e3]
    assert view("/train/vehicle_1/bogie_1/trailing").get("axle_load") == [196.2e3]


def test_names_follow_namespace_node_and_remapping(start, view, tmp_path):
    from wheelset_track_msgs.srv import SetSpeed

    front, root = view("/train/w1/front"), view("")
    forces = root.collect("wheel_loads", "ContactForces")
    summaries = front.collect("summary", "LoadSummary")
    states = front.collect("state", "SimulationState", latched=True)
    told = statuses(front.node)
    node = start(
        *("--ros-args", "-r", "__ns:=/train/w1", "-r", "__node:=front"),
        *("-r", "~/contact_forces:=/wheel_loads", "-r", "~/set_speed:=/drive"),
        scenario="undamaged",
        record__on_start="true",
        record__directory=tmp_path,
        record__name="bag",
    )
    front.until(lambda: len(forces) > 2 and summaries and states)
    graph = front.node
    published = {name for name, _ in graph.get_publisher_names_and_types_by_node("front", "/train/w1")}
    subscribed = {name for name, _ in graph.get_subscriber_names_and_types_by_node("front", "/train/w1")}
    services = {name for name, _ in graph.get_service_names_and_types_by_node("front", "/train/w1")}
    own = "/train/w1/front"
    assert {"/wheel_loads", f"{own}/summary", f"{own}/axle_stress/a1", "/diagnostics"} <= published
    assert {f"{own}/cmd/speed", f"{own}/cmd/tread_damage"} <= subscribed
    assert {"/drive", f"{own}/pause", f"{own}/set_parameters", f"{own}/change_state"} <= services
    everything = published | subscribed | services
    assert not {name for name in everything if "wheelset_track_sim" in name}
    assert f"{own}/contact_forces" not in everything
    assert f"{own}/set_speed" not in everything

    answer = root.call("drive", SetSpeed, speed=25.0, acceleration=10.0)
    assert answer.success, answer.message
    front.until(lambda: summaries[-1].speed == 25.0 and states[-1].revision == answer.revision)
    assert front.get("speed") == [25.0]
    assert front.set(axle_load=180e3).successful
    front.until(lambda: told)
    assert {status.name.partition(": ")[0] for array in told for status in array.status} == {"train/w1/front"}
    assert {status.hardware_id for array in told for status in array.status} == {"train/w1/front"}

    assert node.signal(signal.SIGINT) == 0, node.errors
    recorded = read_bag(tmp_path / "bag")
    received = np.concatenate([chunk.wheel_1 for chunk in forces])
    first = forces[0].first_step
    np.testing.assert_array_equal(recorded.forces[first : first + len(received), 0], received)
    topics = bag_topics(tmp_path / "bag")
    assert {f"{own}/contact_forces", f"{own}/summary", f"{own}/state"} <= topics


def bag_topics(folder):
    from rosbags.rosbag2 import Reader

    with Reader(folder) as reader:
        return set(reader.topics)


@pytest.mark.skipif(shutil.which("ros2") is None, reason="ros2 launch is not installed; PyPI does not have it")
def test_ros2_launch_shows_the_arguments():
    for file in (ROOT / "launch").iterdir():
        shown = subprocess.run(["ros2", "launch", str(file), "--show-args"], capture_output=True, text=True, check=True)
        assert "'params_file':" in shown.stdout
        assert "'record_directory':" in shown.stdout


@pytest.mark.skipif(shutil.which("ros2") is None, reason="ros2 launch is not installed; PyPI does not have it")
def test_ros2_launch_starts_a_bogie(domain, view, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    views = [view(f"/bogie/{name}") for name in ("leading", "trailing")]
    forces = [view.collect("contact_forces", "ContactForces") for view in views]
    launched = subprocess.Popen(["ros2", "launch", "wheelset_track_sim", "bogie.launch.py"], start_new_session=True)
    try:
        for of_node, found in zip(views, forces, strict=True):
            of_node.until(lambda found=found: found)
    finally:
        launched.send_signal(signal.SIGINT)
        assert launched.wait(60) == 0
