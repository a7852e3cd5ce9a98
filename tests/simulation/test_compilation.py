import os
import subprocess
import sys
from pathlib import Path

import pytest

from wheelset_track_sim.simulation import compilation

SIMULATE = """
from wheelset_track_sim.scenario import load_scenario
from wheelset_track_sim.simulation.coupled_kernels import run
from wheelset_track_sim.simulation.simulator import Simulator
Simulator(load_scenario("damage_wheel_1")).advance(10)
print(sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()))
"""


class Child:
    """A process that does nothing, and remembers what was done to it."""

    def __init__(self, status: int = 0) -> None:
        self.returncode, self.commands, self.told = status, [], []

    def __call__(self, command: list[str], **_: object) -> "Child":
        self.commands.append(command)
        return self

    def wait(self) -> int:
        self.told.append("wait")
        return self.returncode

    def terminate(self) -> None:
        self.told.append("terminate")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(compilation.os, "sched_getaffinity", lambda process: {0, 1}, raising=False)
    return tmp_path


@pytest.mark.parametrize("status", [0, 1])
def test_kernels_are_compiled_beside_and_waited_for(folder: Path, monkeypatch: pytest.MonkeyPatch, status: int) -> None:
    child = Child(status)
    monkeypatch.setattr(compilation.subprocess, "Popen", child)
    with compilation.compiled_meanwhile():
        assert child.told == []
    assert child.told == ["wait"]
    assert child.commands == [[sys.executable, "-m", "wheelset_track_sim.simulation.compilation"]]


def test_an_interruption_ends_the_compilation_too(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    child = Child()
    monkeypatch.setattr(compilation.subprocess, "Popen", child)
    with pytest.raises(KeyboardInterrupt), compilation.compiled_meanwhile():
        raise KeyboardInterrupt
    assert child.told == ["terminate", "wait"]


@pytest.mark.parametrize("reason", ["done", "one core"])
def test_no_process_without_need(folder: Path, monkeypatch: pytest.MonkeyPatch, reason: str) -> None:
    child = Child()
    monkeypatch.setattr(compilation.subprocess, "Popen", child)
    if reason == "done":
        (folder / compilation.DONE).touch()
    else:
        monkeypatch.setattr(compilation.os, "sched_getaffinity", lambda process: {0}, raising=False)
    with compilation.compiled_meanwhile():
        pass
    assert child.commands == []


@pytest.mark.slow
def test_a_simulation_finds_all_of_its_step_compiled(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    module = [sys.executable, "-m", "wheelset_track_sim.simulation.compilation"]
    subprocess.run(module, env=environment, check=True, capture_output=True)
    assert len(list(tmp_path.glob(f"kernels/*/{compilation.DONE}"))) == 1
    found = subprocess.run(
        [sys.executable, "-c", SIMULATE], env=environment, check=True, capture_output=True, text=True
    )
    assert found.stdout.split() == ["1", "0"]
