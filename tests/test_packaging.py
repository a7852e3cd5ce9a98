"""What is installed is complete: by pip, by colcon, and as the set-up script leaves it."""

import email
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

README = (ROOT / "README.md").read_text(encoding="utf-8")
SETUP = (ROOT / "tools" / "setup_env.py").read_text(encoding="utf-8")
SCENARIOS = {path.name for path in (ROOT / "config" / "scenarios").glob("*.yaml")}
MESSAGES = {path.name for path in (ROOT / "msg_defs").glob("*/*") if path.suffix in {".msg", ".srv"}}
ASSETS = {
    str(path.relative_to(ROOT))
    for folder in ("report", "explore")
    for path in (ROOT / "wheelset_track_sim" / folder).iterdir()
    if path.suffix in {".css", ".js"}
}


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
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (.*)$", citation, re.MULTILINE) == [wheelset_track_sim.__version__]
    assert re.findall(r"^license: (.*)$", citation, re.MULTILINE) == ["Apache-2.0"]
    assert (ROOT / "resource" / manifest(ROOT).findtext("name")).exists()


def test_the_newest_release_in_the_changelog_is_this_version():
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    releases = [heading for heading in headings if heading != "Unreleased"]
    assert headings[-len(releases) :] == releases, "what is not released is on top"
    assert re.fullmatch(rf"{re.escape(wheelset_track_sim.__version__)} \(\d{{4}}-\d\d-\d\d\)", releases[0])
    tag = f"v{wheelset_track_sim.__version__}"
    assert run(".ci/release-notes", tag, cwd=ROOT).stdout.strip()
    refused = run(".ci/release-notes", "v9.9.9", cwd=ROOT, ok=False)
    assert (refused.returncode, refused.stdout) == (1, "")
    assert refused.stderr == f"release-notes: the tag is v9.9.9, the version is {tag[1:]}: tag {tag}\n"


def test_pythons_are_the_same_everywhere():
    supported = set(re.findall(r"\((\d), (\d+)\)", re.search(r"^SUPPORTED = .*$", SETUP, re.MULTILINE)[0]))
    versions = {".".join(pair) for pair in supported}
    config = ConfigParser()
    config.read(ROOT / "setup.cfg")
    assert set(re.findall(r"Python :: (\d\.\d+)", config["metadata"]["classifiers"])) == versions
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert set(re.findall(r"\d\.\d+", re.search(r"^ +python: \[(.*)\]$", workflow, re.MULTILINE)[1])) == versions
    first, *_, last = sorted(versions, key=lambda version: int(version.partition(".")[2]))
    assert f"Python {first} to {last}" in README


def test_data_are_links_to_what_is_kept_at_the_top():
    data = ROOT / "wheelset_track_sim" / "data"
    for name in ("config", "msg_defs"):
        assert (data / name).readlink() == Path("../..", name)


@pytest.fixture
def unpacked(tree, tmp_path):
    """Source distribution of the tree, unpacked."""
    code = f"from setuptools import build_meta; build_meta.build_sdist({str(tmp_path)!r})"
    run(sys.executable, "-c", code, cwd=tree)
    [archive] = tmp_path.glob("wheelset_track_sim-*.tar.gz")
    shutil.unpack_archive(archive, tmp_path / "unpacked", filter="data")
    [folder] = (tmp_path / "unpacked").iterdir()
    return folder


def files(folder):
    """Files below a folder; not those of linked folders."""
    return {str(Path(place, name).relative_to(folder)) for place, _, names in os.walk(folder) for name in names}


@pytest.mark.slow
def test_source_distribution_holds_what_a_clone_holds(tree, unpacked):
    clone = {name for name in files(tree) if not name.startswith((".git", "wheelset_track_sim.egg-info/"))}
    assert clone - files(unpacked) == set()
    for name in (
        "tools/setup_env.py",
        "requirements/ros-jazzy.txt",
        "msg_defs/CMakeLists.txt",
        "docs/theory/method.md",
        "Makefile",
    ):
        assert (unpacked / name).read_bytes() == (ROOT / name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("source", ["tree", "unpacked"])
def test_wheel_holds_real_copies(source, tmp_path, request):
    folder = request.getfixturevalue(source)
    run(sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "-w", str(tmp_path), str(folder), cwd=tmp_path)
    [wheel] = tmp_path.glob("wheelset_track_sim-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        scenario = archive.read("wheelset_track_sim/data/config/scenarios/undamaged.yaml")
        assert scenario == (ROOT / "config" / "scenarios" / "undamaged.yaml").read_bytes()
    assert {name.split("/")[-1] for name in names if "/data/config/scenarios/" in name} == SCENARIOS
    assert {name.split("/")[-1] for name in names if "/data/msg_defs/" in name} == MESSAGES
    sources = {str(path.relative_to(ROOT)) for path in (ROOT / "wheelset_track_sim").rglob("*.py")}
    assert {name for name in names if name.startswith("wheelset_track_sim/") and name.endswith(".py")} == sources
    assert {"wheelset_track_sim/py.typed", *ASSETS} <= set(names)


def metadata(tree, **env):
    """Metadata of the package as a wheel of the tree would have them."""
    code = "import os; from setuptools import build_meta; print(build_meta.prepare_metadata_for_build_wheel('made'))"
    (tree / "made").mkdir(exist_ok=True)
    name = run(sys.executable, "-c", code, cwd=tree, **env).stdout.split()[-1]
    return email.message_from_string((tree / "made" / name / "METADATA").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_description_has_no_link_that_needs_the_repository(tree):
    found = metadata(tree, WHEELSET_TRACK_SIM_REPOSITORY="")
    assert found["Requires-Python"] == ">=3.10"
    assert found.get_all("Project-URL") is None
    text = found.get_payload()
    assert "docs/theory/method.md says where" in text.replace("\n", " ")
    assert re.findall(r"\]\((?!https?:)", text) == []
    assert re.findall(r"\]\((https?:[^)]+)\)", text) == re.findall(r"\]\((https?:[^)]+)\)", README)


@pytest.mark.slow
def test_description_has_absolute_links_if_the_repository_is_known(tree):
    home = "https://example.org/owner/name"
    found = metadata(tree, WHEELSET_TRACK_SIM_REPOSITORY=home)
    assert f"Source, {home}" in found.get_all("Project-URL")
    links = re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", found.get_payload())
    relative = re.findall(r"(!?)\[[^\]]*\]\(([^)]+)\)", README)
    assert len(links) == len(relative) > 5
    for (image, link), (_, target) in zip(links, relative, strict=True):
        if target.startswith("https:"):
            assert link == target
            continue
        kind, name, path = link.removeprefix(f"{home}/").split("/", 2)
        assert (kind, name) == ("raw" if image else "blob", "HEAD")
        assert path == (f"README.md{target}" if target.startswith("#") else target)


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


def test_the_container_job_runs_the_commands_of_the_readme_for_ros_word_by_word():
    script = run(sys.executable, "tools/readme_ros2.py", "install", "launch", "talk", cwd=ROOT).stdout
    assert run("bash", "-n", "-c", script, cwd=ROOT).stderr == ""
    lines = script.splitlines()
    section = README.partition("\n## ROS 2\n")[2].partition("\n## ")[0]
    commands = re.findall(r"^    ((?:sudo|\.|rosdep|export|colcon|ros2) .*?)(?: +#.*)?$", section, re.MULTILINE)
    assert len(commands) == 13
    places = [next(n for n, line in enumerate(lines) if line.endswith(command)) for command in commands]
    assert places == sorted(places)
    job = (ROOT / ".ci" / "ros2").read_text(encoding="utf-8")
    assert 'eval "$(readme install launch talk)"' in job
    assert run("bash", "-n", ".ci/ros2", cwd=ROOT).stderr == ""


def test_the_script_of_the_readme_reads_answers_and_ends_what_does_not_end(tmp_path):
    """With a stand-in for ``ros2``, which answers as the real one does."""
    tools = tmp_path / "bin"
    tools.mkdir()
    (tools / "ros2").write_text(
        """#!/usr/bin/env bash
case "$*" in
  launch*|"run wheelset_track_sim node"*) trap 'exit 0' INT; echo streaming; while :; do sleep 0.1; done ;;
  topic*) for _ in 1 2 3; do echo 101685.7; echo ---; sleep 0.1; done ;;
  service*) echo "SetSpeed_Response(success=$ACCEPTED, message='')" ;;
  param*) echo "Set parameter successful: revision 2" ;;
  *) echo "ran $*" ;;
esac
"""
    )
    (tools / "ros2").chmod(0o755)
    bash = 'set -eo pipefail -m; eval "$(python3 tools/readme_ros2.py launch talk)"; interrupt node; echo passed'
    code = bash.replace("tools/", f"{ROOT}/tools/").replace("python3", sys.executable)
    path = f"{tools}:{os.environ['PATH']}"
    done = run("bash", "-c", code, cwd=tmp_path, PATH=path, ACCEPTED="True")
    last = ["ran run wheelset_track_sim wheelset-track-sim run damage_wheel_1", "passed"]
    assert [line for line in done.stdout.splitlines() if line in last] == last
    assert "101685.7" in done.stdout
    refused = run("bash", "-c", code, cwd=tmp_path, ok=False, PATH=path, ACCEPTED="False")
    assert refused.returncode != 0
    assert "passed" not in refused.stdout


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
