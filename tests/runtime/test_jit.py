import ast
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import wheelset_track_sim
from wheelset_track_sim.runtime import jit

PACKAGE = Path(wheelset_track_sim.__file__).parent


@pytest.mark.slow
def test_compiled_functions_stand_where_the_cache_digest_looks() -> None:
    for path in PACKAGE.rglob("*.py"):
        names = {
            getattr(decorator, "id", getattr(getattr(decorator, "func", None), "id", ""))
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.FunctionDef)
            for decorator in node.decorator_list
        }
        if names & {"kernel", "inner_kernel", "summing_kernel", "njit", "jit", "overload"}:
            assert path.name.endswith("kernels.py"), path


def test_the_cache_folder_follows_the_kernels(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(jit, "__file__", str(tmp_path / "runtime" / "jit.py"))
    (tmp_path / "runtime").mkdir()
    (tmp_path / "runtime" / "jit.py").write_text("options")
    (tmp_path / "sub").mkdir()
    kernels = tmp_path / "sub" / "some_kernels.py"
    found = set()
    for text in ("one", "two"):
        kernels.write_text(text)
        jit.cache_folder.cache_clear()
        found.add(jit.cache_folder())
    (tmp_path / "runtime" / "jit.py").write_text("other options")
    jit.cache_folder.cache_clear()
    found.add(jit.cache_folder())
    jit.cache_folder.cache_clear()
    assert len(found) == 3


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Empty cache of kernels, on two cores; processes find the modules in it."""
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(jit, "trusted_folder", lambda: tmp_path)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1}, raising=False)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return tmp_path


KERNEL = """
import logging
logging.basicConfig(format="%(message)s")
from wheelset_track_sim.samples.principal_kernels import principal_stresses
import numpy as np
found = np.zeros((1, 3))
principal_stresses(np.array([[3.0, 2.0, 1.0, 0.5, 0.0, 0.0]]), found)
print(found, sum(principal_stresses.stats.cache_misses.values()))
"""


def kernel_in_a_process(caches: Path) -> subprocess.CompletedProcess[str]:
    """A process that calls one kernel, which it stores below ``caches`` or finds there."""
    return subprocess.run(
        [sys.executable, "-c", KERNEL],
        env=os.environ | {"NUMBA_CACHE_DIR": str(caches)},
        capture_output=True,
        text=True,
        check=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("kept", [0, 100])
def test_a_damaged_kernel_is_compiled_again(tmp_path: Path, suffix: str, kept: int) -> None:
    first = kernel_in_a_process(tmp_path)
    stored = list(tmp_path.rglob(f"*principal_stresses*{suffix}"))
    assert stored
    for path in stored:
        path.write_bytes(path.read_bytes()[:kept])
    again = kernel_in_a_process(tmp_path)
    assert "compiled again" in again.stderr
    assert again.stdout == first.stdout
    third = kernel_in_a_process(tmp_path)
    assert (third.stdout, third.stderr) == (first.stdout, "")


@pytest.mark.slow
def test_no_process_uses_a_kernel_that_it_has_compiled_itself(tmp_path: Path) -> None:
    """Otherwise the first run after an installation had other last bits than those that simulate it again."""
    assert kernel_in_a_process(tmp_path).stdout.endswith("] 0\n")


@pytest.mark.slow
def test_kernels_that_others_can_write_are_not_used(tmp_path: Path) -> None:
    kernel_in_a_process(tmp_path)
    [folder] = (tmp_path / "kernels").iterdir()
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    before = sorted(folder.rglob("*"))
    refused = kernel_in_a_process(tmp_path)
    assert f"{folder} are not used, because other users can write there: remove" in refused.stderr
    assert sorted(folder.rglob("*")) == before


def compiling(folder: Path, code: str = "") -> str:
    """Name of a module that takes half a second, leaves a file and then executes ``code``."""
    (folder / "compiling.py").write_text(
        f"import time; time.sleep(0.5)\nopen({str(folder / 'ran')!r}, 'w').close()\n{code}"
    )
    return "compiling"


@pytest.mark.parametrize("code", ["", "raise SystemExit(1)"])
def test_kernels_are_compiled_beside_and_waited_for(folder: Path, code: str) -> None:
    with jit.compiled_meanwhile(compiling(folder, code), "some"):
        assert not (folder / "ran").exists()
    assert (folder / "ran").exists()


def test_an_interruption_ends_the_compilation_too(folder: Path) -> None:
    def interrupted() -> None:
        with jit.compiled_meanwhile(compiling(folder, "time.sleep(600)"), "some"):
            while not (folder / "ran").exists():
                time.sleep(0.01)
            raise KeyboardInterrupt

    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert time.monotonic() - start < 300


@pytest.mark.parametrize("reason", ["done", "one core"])
def test_no_process_without_need(folder: Path, monkeypatch: pytest.MonkeyPatch, reason: str) -> None:
    if reason == "done":
        jit.compiled("some").touch()
    else:
        monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0}, raising=False)
    with jit.compiled_meanwhile(compiling(folder), "some"):
        pass
    assert not (folder / "ran").exists()


def test_kernels_are_compiled_ahead_once_and_not_waited_for(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "_AHEAD", {})
    module = compiling(folder, "time.sleep(600)")
    for _ in range(2):
        jit.compile_ahead(module, "some")
    [process] = jit._AHEAD.values()
    assert process.poll() is None
    process.terminate()
    process.wait()


def test_nothing_is_compiled_ahead_without_need(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "_AHEAD", {})
    jit.compiled("some").touch()
    jit.compile_ahead(compiling(folder), "some")
    assert jit._AHEAD == {}


def test_nan_survives_a_reordered_sum() -> None:
    from wheelset_track_sim.dynamics.paper_kernels import _convolution

    green, past = np.ones(64), np.ones(64)
    past[40] = np.nan
    assert np.isnan(_convolution(green, past, 63))
