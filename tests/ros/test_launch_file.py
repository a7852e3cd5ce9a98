"""Launch files by stand-ins: which nodes, with which arguments; ``test_launched_nodes`` starts them."""

import runpy
from types import SimpleNamespace

import pytest

from support.launch_stand_in import LaunchFile, install
from support.paths import ROOT
from wheelset_track_sim.errors import InputError, WheelsetTrackError
from wheelset_track_sim.inputs.yaml12 import parse

ALL = sorted(path.name for path in (ROOT / "launch").iterdir())
FILES = [name for name in ALL if name != "replay.launch.py"]
IN_COMMON = {
    "params_file",
    "namespace",
    "scenario",
    "autostart",
    "real_time_factor",
    "use_sim_time",
    "record",
    "record_directory",
    "log_level",
}


@pytest.fixture(autouse=True)
def _stand_ins(monkeypatch):
    install(monkeypatch)


def sections(file):
    return {name: content["ros__parameters"] for name, content in parse(file.read_text(), file.name).items()}


def test_one_for_each_way_to_run():
    assert ALL == [
        "bogie.launch.py",
        "fleet.launch.py",
        "replay.launch.py",
        "train.launch.py",
        "wheelset_track_sim.launch.py",
    ]


@pytest.mark.parametrize("file", FILES)
def test_every_argument_has_a_default_and_a_description(file):
    launch = LaunchFile(file)
    assert set(launch.arguments) >= IN_COMMON
    assert len(launch.declared) == len(launch.arguments)
    for item in launch.declared:
        assert isinstance(item.named["default_value"], str)
        assert len(item.named["description"]) > 10


@pytest.mark.parametrize("file", FILES)
def test_parameter_file_is_a_shipped_one_and_holds_unless_told(file, tmp_path):
    for node in LaunchFile(file).nodes():
        path = ROOT / "wheelset_track_sim" / "data" / "config" / node.file.rpartition("/")[2]
        assert (node.file, node.given) == (str(path), {})
        assert path.is_file()
    mine = tmp_path / "mine.yaml"
    mine.touch()
    [*_, other] = LaunchFile(file).nodes(params_file=str(mine))
    assert other.file == str(mine)


@pytest.mark.parametrize("file", FILES)
def test_arguments_stand_above_the_parameter_file(file):
    given = {
        "scenario": "undamaged",
        "autostart": "false",
        "real_time_factor": "2",
        "use_sim_time": "true",
        "record": "true",
        "record_directory": "2026",
    }
    for node in LaunchFile(file).nodes(**given, log_level="warn"):
        assert node.given == {
            "scenario": "undamaged",
            "autostart": False,
            "real_time_factor": 2.0,
            "use_sim_time": True,
            "record.on_start": True,
            "record.directory": "2026",
        }
        assert node.ros_arguments == ["--log-level", "warn"]
        known = {"use_sim_time", *sections(ROOT / "config" / "node.yaml")["/**"]}
        assert set(node.given) <= known


@pytest.mark.parametrize(
    ("file", "given", "names"),
    [
        ("wheelset_track_sim.launch.py", {}, ["/wheelset_track_sim"]),
        ("wheelset_track_sim.launch.py", {"name": "front", "namespace": "train/w1"}, ["/train/w1/front"]),
        ("fleet.launch.py", {}, ["/wheelset_1", "/wheelset_2", "/wheelset_3"]),
        ("fleet.launch.py", {"wheelsets": "a,b", "namespace": "/x/"}, ["/x/a", "/x/b"]),
        ("bogie.launch.py", {}, ["/bogie/leading", "/bogie/trailing"]),
        ("bogie.launch.py", {"namespace": ""}, ["/leading", "/trailing"]),
        (
            "train.launch.py",
            {},
            [f"/train/vehicle_1/bogie_{bogie}/{name}" for bogie in (1, 2) for name in ("leading", "trailing")],
        ),
        (
            "train.launch.py",
            {"vehicles": "2", "bogies": "1", "namespace": ""},
            [f"/vehicle_{vehicle}/bogie_1/{name}" for vehicle in (1, 2) for name in ("leading", "trailing")],
        ),
    ],
)
def test_names_of_the_nodes(file, given, names):
    assert [node.full_name for node in LaunchFile(file).nodes(**given)] == names


@pytest.mark.parametrize(
    ("file", "given"),
    [
        ("fleet.launch.py", {"wheelsets": "0"}),
        ("fleet.launch.py", {"wheelsets": "a,a"}),
        ("train.launch.py", {"vehicles": "0"}),
        ("train.launch.py", {"bogies": "two"}),
    ],
)
def test_numbers_and_names_that_make_no_sense_are_refused_by_name(file, given):
    [argument] = given
    with pytest.raises(InputError, match=f"^{argument}:="):
        LaunchFile(file).nodes(**given)


@pytest.mark.parametrize("file", ["fleet.launch.py", "bogie.launch.py", "train.launch.py"])
def test_sections_of_shipped_files_are_of_nodes_that_are_launched(file):
    launched = [LaunchFile(name).nodes() for name in FILES]
    names = {node.full_name for nodes in launched for node in nodes}
    own = LaunchFile(file).nodes()
    found = sections(ROOT / "config" / own[0].file.rpartition("/")[2])
    assert set(found) <= {"/**", *names}
    assert set(found) & {node.full_name for node in own}


def test_a_replay_takes_all_its_parameters_as_arguments():
    launch = LaunchFile("replay.launch.py")
    [plain] = launch.nodes()
    assert (plain.executable, plain.full_name, plain.given) == ("replay", "/wheelset_track_sim", {})
    assert all(len(item.named["description"]) > 10 for item in launch.declared)
    [node] = launch.nodes(
        bag="run.mcap", rate="0", loop="true", duration="2.5", prefix="~", namespace="train", name="w1"
    )
    assert node.full_name == "/train/w1"
    assert node.given == {"bag": "run.mcap", "rate": 0.0, "loop": True, "duration": 2.5, "prefix": "~"}
    known = {*sections(ROOT / "config" / "replay.yaml")["/**"], "use_sim_time"}
    assert set(launch.arguments) == known | {"params_file", "namespace", "name", "log_level"}


@pytest.mark.parametrize("program", ["node", "replay"])
def test_executable_is_there(program):
    assert (ROOT / "tools" / program).exists()
    assert f"tools/{program}" in (ROOT / "setup.py").read_text()
    assert runpy.run_path(str(ROOT / "tools" / program))["main"]


@pytest.mark.parametrize("file", ALL)
@pytest.mark.parametrize(
    ("argument", "value", "words"),
    [
        ("params_file", "/nowhere.yaml", "params_file = /nowhere.yaml is not a file"),
        ("use_sim_time", "maybe", "use_sim_time = maybe is neither true nor false"),
        ("log_level", "loud", "loud is not a known log_level: known are debug"),
    ],
)
def test_values_that_no_node_could_use_are_refused(file, argument, value, words):
    with pytest.raises(InputError, match=words):
        LaunchFile(file).nodes(**{argument: value})


def test_numbers_are_numbers():
    with pytest.raises(InputError, match="real_time_factor = fast is not a number"):
        LaunchFile("bogie.launch.py").nodes(real_time_factor="fast")


@pytest.mark.parametrize(
    ("file", "status", "ends"),
    [
        ("wheelset_track_sim.launch.py", 2, True),
        ("wheelset_track_sim.launch.py", 1, True),
        ("wheelset_track_sim.launch.py", 0, False),
        ("wheelset_track_sim.launch.py", -2, False),
        ("bogie.launch.py", 2, True),
        ("bogie.launch.py", 1, False),  # the other wheelset goes on
    ],
)
def test_a_process_that_cannot_go_on_ends_the_launch(file, status, ends):
    [node, *_] = LaunchFile(file).nodes()
    event = SimpleNamespace(returncode=status, process_name="node-1")
    if ends:
        with pytest.raises(WheelsetTrackError, match=f"node-1 ended with status {status}"):
            node.on_exit(event, None)
    else:
        node.on_exit(event, None)
