"""What is installed is complete: by pip, by colcon, and as the set-up script leaves it."""

import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from configparser import ConfigParser
from pathlib import Path

import pytest

import wheelset_track_sim
from support.paths import ROOT

SCENARIOS = {path.name for path in (ROOT / "config" / "scenarios").glob("*.yaml")}
MESSAGES = {path.name for path in (ROOT / "msg_defs").glob("*/*") if path.suffix in {".msg", ".srv"}}
REPORT = {path.name for path in (ROOT / "wheelset_track_sim" / "report").iterdir() if path.suffix in {".css", ".js"}}


@pytest.fixture
def tree(tmp_path):
    """Copy of the source tree as a clone has it, symlinks and all."""
    copy = tmp_path / "clone"
    copy.mkdir()
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    for name in listed.stdout.splitlines():
        source, target = ROOT / name, copy / name
        if source.is_symlink() or source.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target, follow_symlinks=False)
    return copy


def run(*command, cwd, ok=True, **env):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=240, env={**os.environ, **env})
    assert not ok or done.returncode == 0, done.stdout + done.stderr
    return done


def manifest(folder):
    return ET.parse(folder / "package.xml").getroot()


def test_versions_and_licences_agree():
    for folder in (ROOT, ROOT / "msg_defs"):
        assert manifest(folder).findtext("version") == wheelset_track_sim.__version__
        assert manifest(folder).findtext("license") == "Apache-2.0"
    assert (ROOT / "resource" / manifest(ROOT).findtext("name")).exists()


def test_rosdep_keys_cover_the_requirements():
    keys = {entry.text for entry in manifest(ROOT).findall("exec_depend")}
    config = ConfigParser()
    config.read(ROOT / "setup.cfg")
    requirements = set(re.findall(r"^[\w.-]+", config["options"]["install_requires"], re.MULTILINE))
    named = {re.sub(r"^python3-|-pip$", "", key) for key in keys}
    brought = {"zstandard", "threadpoolctl"}  # by rosbags and sklearn
    assert requirements - brought == named & requirements
    assert {"python3-ruamel.yaml", "python3-sklearn", "rclpy", "wheelset_track_msgs"} <= keys


def test_data_are_links_to_what_is_kept_at_the_top():
    data = ROOT / "wheelset_track_sim" / "data"
    for name in ("config", "msg_defs"):
        assert (data / name).readlink() == Path("../..", name)


@pytest.mark.slow
def test_wheel_holds_real_copies(tree, tmp_path):
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "-w", str(tmp_path), str(tree), cwd=tmp_path)
    [wheel] = tmp_path.glob("wheelset_track_sim-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        scenario = archive.read("wheelset_track_sim/data/config/scenarios/undamaged.yaml")
        assert scenario == (ROOT / "config" / "scenarios" / "undamaged.yaml").read_bytes()
    assert {name.split("/")[-1] for name in names if "/data/config/scenarios/" in name} == SCENARIOS
    assert {name.split("/")[-1] for name in names if "/data/msg_defs/" in name} == MESSAGES
    sources = {str(path.relative_to(tree)) for path in (tree / "wheelset_track_sim").rglob("*.py")}
    assert {name for name in names if name.startswith("wheelset_track_sim/") and name.endswith(".py")} == sources
    assert {"wheelset_track_sim/py.typed", *(f"wheelset_track_sim/report/{name}" for name in REPORT)} <= set(names)


@pytest.mark.slow
@pytest.mark.ros
def test_colcon_installs_what_ros2_run_and_ros2_launch_look_for(tree, tmp_path):
    colcon = Path(sys.prefix) / "bin" / "colcon"
    if not colcon.exists():
        pytest.skip("colcon is not in this environment: make test brings it")
    found = run(str(colcon), "list", "--base-paths", ".", "msg_defs", cwd=tree).stdout
    assert re.findall(r"^(\S+)\t.*\((\S+)\)$", found, re.MULTILINE) == [
        ("wheelset_track_msgs", "ros.ament_cmake"),
        ("wheelset_track_sim", "ros.ament_python"),
    ]
    run(str(colcon), "build", "--packages-select", "wheelset_track_sim", cwd=tree, AMENT_PREFIX_PATH=sys.prefix)
    prefix = tree / "install" / "wheelset_track_sim"
    share = prefix / "share" / "wheelset_track_sim"
    assert (prefix / "share/ament_index/resource_index/packages/wheelset_track_sim").exists()
    assert (share / "package.xml").exists()
    assert {path.name for path in (share / "launch").iterdir()} == {p.name for p in (ROOT / "launch").iterdir()}
    for program in ("node", "replay", "wheelset-track-sim"):
        assert os.access(prefix / "lib" / "wheelset_track_sim" / program, os.X_OK)
    [installed] = prefix.glob("lib/python*/site-packages/wheelset_track_sim")
    assert {path.name for path in (installed / "data/config/scenarios").iterdir()} == SCENARIOS
    assert not any(path.is_symlink() for path in installed.rglob("*"))
    shutil.rmtree(tree / "config")  # what is installed stands alone
    code = "from wheelset_track_sim.scenario import load_scenario as load; print(load('undamaged').name)"
    program = [sys.executable, "-c", code]
    path = str(installed.parent)
    assert run(*program, cwd=tmp_path, PYTHONPATH=path).stdout.strip() == "undamaged"
    node = run(
        sys.executable, str(prefix / "lib/wheelset_track_sim/node"), "-x", cwd=tmp_path, ok=False, PYTHONPATH=path
    )
    assert (node.returncode, node.stderr.split(":")[:2]) == (
        2,
        ["wheelset-track-sim", " -x is not an argument of the node"],
    )


def setup_env(tree, *extras, **env):
    return run(sys.executable, "tools/setup_env.py", *extras, cwd=tree, ok=False, **env)


def test_another_ros_distribution_is_refused(tree):
    done = setup_env(tree, ROS_DISTRO="humble")
    assert done.returncode == 1
    assert done.stderr.startswith("setup: ROS 2 humble is sourced, Jazzy is needed")
    assert not (tree / ".venv").exists()


def test_missing_compiler_is_named(tree):
    done = setup_env(tree, CXX="no-such-compiler", ROS_DISTRO="")
    assert done.returncode == 1
    assert "sudo apt install build-essential" in done.stderr
    assert not (tree / ".venv").exists()


@pytest.mark.slow
def test_failing_step_says_what_to_do_and_is_done_by_the_next_call(tree):
    offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "", "PIP_RETRIES": "0", "ROS_DISTRO": ""}
    first = setup_env(tree, **offline)
    assert first.returncode == 1
    assert "check the network and pip's index settings, then call again" in first.stderr
    assert "create .venv" in first.stdout
    second = setup_env(tree, **offline)
    assert second.returncode == 1
    assert "create .venv" not in second.stdout
    assert "install ROS 2 Jazzy" in second.stdout
