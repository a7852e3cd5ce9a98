"""Files of the container: what can be checked without Docker, and what Docker and hadolint say where they are."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from support.paths import ROOT
from wheelset_track_sim.inputs.yaml12 import parse
from wheelset_track_sim.monitoring.prometheus import Endpoint, Metrics

COMPOSE = parse((ROOT / "compose.yaml").read_text(encoding="utf-8"), "compose.yaml")
DOCKERFILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")


def found(tool: str) -> str:
    path = shutil.which(tool)
    if path is None:
        pytest.skip(f"no {tool} here")
    return path


def test_hadolint_accepts_the_dockerfile() -> None:
    subprocess.run([found("hadolint"), "Dockerfile"], cwd=ROOT, check=True, timeout=60)


def test_docker_accepts_the_compose_file() -> None:
    docker = found("docker")
    if subprocess.run([docker, "compose", "version"], capture_output=True, check=False, timeout=60).returncode:
        pytest.skip("docker has no compose here")
    subprocess.run([docker, "compose", "config", "--quiet"], cwd=ROOT, check=True, timeout=60)


def test_the_image_gets_what_the_set_up_reads(tmp_path: Path) -> None:
    """The package and its messages are built from what .dockerignore lets through."""
    kept = [line[1:] for line in (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines() if line[:1] == "!"]
    assert all((ROOT / name).exists() for name in kept)
    read = {"tools", "requirements", "setup.py", "setup.cfg", "pyproject.toml", "README.md", "package.xml", "msg_defs"}
    sources = re.findall(r'files\("(\w+)|\["(\w+)/', (ROOT / "setup.py").read_text(encoding="utf-8"))
    read |= {"wheelset_track_sim", ".container", *(name for pair in sources for name in pair if name)}
    assert read == {*kept}


def test_containers_have_few_rights_and_open_ports_on_this_machine_only() -> None:
    assert re.search(r"^USER \d{5}$", DOCKERFILE, re.MULTILINE)
    for service in COMPOSE["services"].values():
        assert service["cap_drop"] == ["ALL"]
        assert "network_mode" not in service
        assert "privileged" not in service
        assert all(port.startswith("127.0.0.1:") for port in service.get("ports", []))


def test_parameters_of_the_node_exist() -> None:
    known = parse((ROOT / "config" / "node.yaml").read_text(encoding="utf-8"), "node.yaml")["/**"]["ros__parameters"]
    given = [re.findall(r"([\w.]+):=", text) for text in (DOCKERFILE, " ".join(COMPOSE["services"]["node"]["command"]))]
    assert [*map(len, given)] == [2, 3]
    assert all(name in known for names in given for name in names)


@pytest.mark.parametrize("file", ["with-ros", "healthy"])
def test_programs_of_the_image_can_run(file: str) -> None:
    assert os.access(ROOT / ".container" / file, os.X_OK)


def test_a_node_is_healthy_while_it_serves_metrics() -> None:
    pytest.importorskip("prometheus_client")
    endpoint = Endpoint(Metrics(), 0)
    command = [str(ROOT / ".container" / "healthy")]
    try:
        env = os.environ | {"METRICS_PORT": str(endpoint.port)}
        subprocess.run(command, env=env, check=True, timeout=60)
    finally:
        endpoint.close()
    assert subprocess.run(command, env=env, capture_output=True, check=False, timeout=60).returncode == 1
